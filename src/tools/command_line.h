#pragma once

#include <boost/program_options.hpp>

namespace ring_gyro::tools {

/// Parses the command line; values are also stored in the targets of the options. `positional`: the
/// option that gets the words without an option name, at most `most` of them (-1: any number);
/// nullptr: no such words are allowed.
boost::program_options::variables_map parseCommandLine(
    int argc, char** argv, const boost::program_options::options_description& description,
    const char* positional = nullptr, int most = -1);

}  // namespace ring_gyro::tools
