#pragma once

#include <string>

namespace cvg {

/// Whether a MATLAB file holds what it says it holds: each variable is there to its last byte, and
/// the sizes that it claims are those of its data. libmatio takes both on trust, reserves what is
/// claimed and reads zeros where a file has been cut. Takes memory for no data.
///
/// Throws LogError naming the variable. The versions: of MATLAB's save, "-v6" and "-v7" (MAT 5,
/// plain or compressed variable by variable) and "-v7.3" (HDF5, which from then on prints no errors
/// of its own in this process).
void requireWholeMat5(const std::string& path);
void requireWholeMat73(const std::string& path);

}  // namespace cvg
