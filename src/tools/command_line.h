#pragma once

#include <boost/program_options.hpp>

namespace ring_gyro::tools {

/// What the command line says, stored in the targets of the options too. `positional`: the option
/// of words that stand by themselves, at most `most` of them, -1: any number; nullptr: none may.
boost::program_options::variables_map parseCommandLine(
    int argc, char** argv, const boost::program_options::options_description& description,
    const char* positional = nullptr, int most = -1);

}  // namespace ring_gyro::tools
