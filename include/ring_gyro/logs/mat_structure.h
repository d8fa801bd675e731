#pragma once

#include <string>

namespace cvg {

/// Checks that a MATLAB file is complete: each variable is there to its last byte, and its declared
/// sizes are those of its data. libmatio does not check this: it allocates the declared size and
/// reads zeros where a file has been cut. These functions do not allocate memory for the data.
///
/// Throw LogError, naming the variable. Versions of MATLAB's save: "-v6" and "-v7" (MAT 5, each
/// variable plain or compressed), and "-v7.3" (HDF5; after this call the HDF5 library prints no
/// errors of its own in this process).
void requireWholeMat5(const std::string& path);
void requireWholeMat73(const std::string& path);

}  // namespace cvg
