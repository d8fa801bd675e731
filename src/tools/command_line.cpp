#include "command_line.h"

namespace ring_gyro::tools {

namespace options = boost::program_options;

options::variables_map parseCommandLine(int argc, char** argv,
                                        const options::options_description& description,
                                        const char* positional, int most) {
  options::positional_options_description positions;
  if (positional) positions.add(positional, most);
  options::variables_map values;
  options::store(
      options::command_line_parser(argc, argv).options(description).positional(positions).run(),
      values);
  options::notify(values);
  return values;
}

}  // namespace ring_gyro::tools
