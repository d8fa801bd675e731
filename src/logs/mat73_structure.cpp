#include <hdf5.h>

#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "ring_gyro/logs/log_error.h"
#include "ring_gyro/logs/mat_structure.h"

namespace ring_gyro {
namespace {

constexpr double kMostDeflated = 1032.0;  // bytes that one byte of deflate can stand for
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
  operator hid_t() const { return id_; }
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// HDF5 prints a page for each fault unless it is told not to.
class QuietErrors {
 public:
  QuietErrors() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

/// How many chunks of a dataset are in the file, of how many; nothing to tell without chunks.
struct Chunks {
  double claimed = 0.0;
  double held = 0.0;
};

Chunks chunksOf(hid_t dataset, hid_t space, hid_t layout, const std::vector<hsize_t>& dimensions) {
  Chunks chunks;
#if H5_VERSION_GE(1, 10, 5)
  std::vector<hsize_t> chunk(dimensions.size());
  if (H5Pget_chunk(layout, static_cast<int>(chunk.size()), chunk.data()) < 0) return chunks;
  chunks.claimed = 1.0;
  for (std::size_t k = 0; k < chunk.size(); ++k) {
    const hsize_t whole = dimensions[k] / chunk[k] + (dimensions[k] % chunk[k] != 0 ? 1 : 0);
    chunks.claimed *= static_cast<double>(whole);
  }
  hsize_t held = 0;
  if (H5Dget_num_chunks(dataset, space, &held) >= 0) chunks.held = static_cast<double>(held);
#endif
  return chunks;
}

/// What is wrong with a dataset; empty: nothing.
std::string faultOf(hid_t dataset, double file_size) {
  const Handle space(H5Dget_space(dataset), H5Sclose);
  const Handle type(H5Dget_type(dataset), H5Tclose);
  const Handle layout(H5Dget_create_plist(dataset), H5Pclose);
  if (!space.ok() || !type.ok() || !layout.ok()) return "cannot be read";
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0) return "cannot be read";
  std::vector<hsize_t> dimensions(static_cast<std::size_t>(rank));
  if (rank > 0) H5Sget_simple_extent_dims(space, dimensions.data(), nullptr);
  double claimed = static_cast<double>(H5Tget_size(type));  // bytes; exact up to 2^53
  for (const hsize_t dimension : dimensions) claimed *= static_cast<double>(dimension);
  if (claimed == 0.0) return "";
  const auto held = static_cast<double>(H5Dget_storage_size(dataset));
  const std::string says = "claims " + std::to_string(claimed) + " bytes and holds ";
  const H5D_layout_t kind = H5Pget_layout(layout);
  if (kind == H5D_CHUNKED) {
    const Chunks chunks = chunksOf(dataset, space, layout, dimensions);
    if (held > file_size || claimed > kMostDeflated * held) return says + std::to_string(held);
    if (chunks.held < chunks.claimed) {
      return "claims " + std::to_string(chunks.claimed) + " chunks and holds " +
             std::to_string(chunks.held);
    }
    return "";
  }
  if (kind == H5D_CONTIGUOUS) {
    const haddr_t offset = H5Dget_offset(dataset);
    const bool there = offset != HADDR_UNDEF && static_cast<double>(offset) + held <= file_size;
    if (!there) return says + "none";
  }
  return held < claimed ? says + std::to_string(held) : "";
}

struct Visit {
  double file_size = 0.0;
  std::string name;
  std::string fault;
};

herr_t visit(hid_t group, const char* name, const H5L_info_t* info, void* data) {
  if (info->type != H5L_TYPE_HARD) return 0;
  auto& state = *static_cast<Visit*>(data);
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
  const QuietErrors quiet;
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

}  // namespace ring_gyro
