#include <hdf5.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "ring_gyro/common/number_text.h"
#include "ring_gyro/logs/log_error.h"
#include "ring_gyro/logs/mat_structure.h"

namespace cvg {
namespace {

constexpr double kMostDeflated = 1032.0;  // most bytes that one byte of deflate can contain
constexpr std::size_t kMostDimensions = 512;
constexpr char kMend[] = "the file is damaged or not whole: copy or save it again";

/// An identifier of HDF5, closed by the function for its kind.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  // NOLINTNEXTLINE(google-explicit-constructor): a handle is what the calls of HDF5 take
  operator hid_t() const { return id_; }
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

std::string text(double value) {
  std::string result;
  appendNumber(result, value);
  return result;
}

std::string claims(double claimed, const char* what, double held) {
  return "claims " + text(claimed) + " " + what + " and holds " + text(held);
}

/// The fault of a dataset stored in chunks; each chunk must be complete in the file.
std::string faultOfChunks(hid_t dataset, hid_t layout, const std::vector<hsize_t>& dimensions,
                          double number_size, double file_size) {
  std::vector<hsize_t> chunk(dimensions.size());
  if (H5Pget_chunk(layout, static_cast<int>(chunk.size()), chunk.data()) < 0) {
    return "cannot be read";
  }
  double claimed = 1.0;
  double bytes = number_size;
  for (std::size_t k = 0; k < chunk.size(); ++k) {
    claimed *= std::ceil(static_cast<double>(dimensions[k]) / static_cast<double>(chunk[k]));
    bytes *= static_cast<double>(chunk[k]);
  }
  bytes *= claimed;
  const auto held = static_cast<double>(H5Dget_storage_size(dataset));
  const double most = H5Pget_nfilters(layout) > 0 ? kMostDeflated * held : held;
  if (held > file_size || bytes > most) return claims(bytes, "bytes", held);
#if H5_VERSION_GE(1, 10, 5)
  hsize_t count = 0;
  const Handle space(H5Dget_space(dataset), H5Sclose);
  if (H5Dget_num_chunks(dataset, space, &count) < 0) return "cannot be read";
  if (static_cast<double>(count) < claimed) {
    return claims(claimed, "chunks", static_cast<double>(count));
  }
#endif
  return "";
}

/// The fault of an array that MATLAB marks as empty: its numbers are the dimensions, one of which
/// must be zero.
std::string faultOfEmpty(hid_t dataset, double bytes) {
  if (H5Aexists(dataset, "MATLAB_empty") <= 0) return "";
  const Handle attribute(H5Aopen(dataset, "MATLAB_empty", H5P_DEFAULT), H5Aclose);
  const Handle one(H5Aget_space(attribute), H5Sclose);
  std::uint64_t is_empty = 0;
  if (H5Sget_simple_extent_npoints(one) != 1 ||
      H5Aread(attribute, H5T_NATIVE_UINT64, &is_empty) < 0) {
    return "cannot be read";
  }
  if (is_empty == 0) return "";
  std::vector<std::uint64_t> dimensions(kMostDimensions);
  if (bytes > static_cast<double>(kMostDimensions)) return "has too many dimensions";
  if (H5Dread(dataset, H5T_NATIVE_UINT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, dimensions.data()) < 0) {
    return "cannot be read";
  }
  double claimed = 1.0;
  const Handle space(H5Dget_space(dataset), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  for (hssize_t k = 0; k < count; ++k) {
    claimed *= static_cast<double>(dimensions[static_cast<std::size_t>(k)]);
  }
  return claimed == 0.0 ? "" : claims(claimed, "numbers", 0.0);
}

/// The fault of a dataset; empty if there is none.
std::string faultOf(hid_t dataset, double file_size) {
  const Handle space(H5Dget_space(dataset), H5Sclose);
  const Handle type(H5Dget_type(dataset), H5Tclose);
  const Handle layout(H5Dget_create_plist(dataset), H5Pclose);
  if (!space.ok() || !type.ok() || !layout.ok()) return "cannot be read";
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0) return "cannot be read";
  std::vector<hsize_t> dimensions(static_cast<std::size_t>(rank));
  if (rank > 0) H5Sget_simple_extent_dims(space, dimensions.data(), nullptr);
  const auto number_size = static_cast<double>(H5Tget_size(type));
  double claimed = number_size;  // bytes; exact up to 2^53
  for (const hsize_t dimension : dimensions) claimed *= static_cast<double>(dimension);
  if (claimed == 0.0) return "";
  const H5D_layout_t kind = H5Pget_layout(layout);
  if (kind == H5D_CHUNKED) {
    const std::string fault = faultOfChunks(dataset, layout, dimensions, number_size, file_size);
    return fault.empty() ? faultOfEmpty(dataset, claimed) : fault;
  }
  auto held = static_cast<double>(H5Dget_storage_size(dataset));
  if (kind == H5D_CONTIGUOUS) {
    const haddr_t offset = H5Dget_offset(dataset);
    if (offset == HADDR_UNDEF || static_cast<double>(offset) + held > file_size) held = 0.0;
  }
  return held < claimed ? claims(claimed, "bytes", held) : faultOfEmpty(dataset, claimed);
}

struct Visit {
  double file_size = 0.0;
  std::string name;
  std::string fault;
};

herr_t visit(hid_t group, const char* name, const H5L_info_t* info, void* data) {
  auto& state = *static_cast<Visit*>(data);
  if (info->type != H5L_TYPE_HARD) {
    state.name = name;
    state.fault = "is a link to another place, which MATLAB does not write";
    return 1;
  }
  const Handle object(H5Oopen(group, name, H5P_DEFAULT), H5Oclose);
  state.name = name;
  if (!object.ok()) {
    state.fault = "cannot be read";
  } else if (H5Iget_type(object) == H5I_DATASET) {
    state.fault = faultOf(object, state.file_size);
  }
  return state.fault.empty() ? 0 : 1;
}

}  // namespace

void requireWholeMat73(const std::string& path) {
  // HDF5 would print a page per fault, also when libmatio reads the file. We report all in one
  // line.
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.ok()) throw LogError(path, "", "cannot be read as HDF5; is it cut?", kMend);
  Visit state;
  hsize_t size = 0;
  if (H5Fget_filesize(file, &size) >= 0) state.file_size = static_cast<double>(size);
  const herr_t code = H5Lvisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, visit, &state);
  if (code == 0) return;
  throw LogError(path, state.name.empty() ? "" : "variable " + state.name,
                 state.fault.empty() ? "cannot be read" : state.fault, kMend);
}

}  // namespace cvg
