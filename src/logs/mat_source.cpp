#include "ring_gyro/logs/mat_source.h"

#include <matio.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "ring_gyro/logs/log_error.h"
#include "ring_gyro/logs/mat_structure.h"

namespace cvg {
namespace {

constexpr std::size_t kMostColumns = 100000;

struct CloseFile {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using File = std::unique_ptr<mat_t, CloseFile>;
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

/// To be called before libmatio opens the file.
void requireWhole(const std::string& path) {
  std::array<char, 128> header{};
  std::ifstream(path, std::ios::binary).read(header.data(), header.size());
  // The last four bytes: a version and the mark "MI", each a word of 16 bits.
  const std::string_view end(header.data() + 124, 4);
  if (end == std::string_view("\0\2IM", 4) || end == std::string_view("\2\0MI", 4)) {
    requireWholeMat73(path);
  } else if (end == std::string_view("\0\1IM", 4) || end == std::string_view("\1\0MI", 4)) {
    requireWholeMat5(path);
  } else {
    throw LogError(path, "", "has a damaged header", "copy the file or save it again");
  }
}

File openFile(const std::string& path) {
  File file(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (!file) {
    throw LogError(path, "", "cannot be read as a MATLAB file",
                   "save it again with save(..., '-v7') or '-v7.3'");
  }
  return file;
}

bool isNumeric(const matvar_t& variable) {
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
    case MAT_C_SINGLE:
    case MAT_C_INT8:
    case MAT_C_UINT8:
    case MAT_C_INT16:
    case MAT_C_UINT16:
    case MAT_C_INT32:
    case MAT_C_UINT32:
    case MAT_C_INT64:
    case MAT_C_UINT64:
      return variable.rank == 2 && variable.isComplex == 0;
    default:
      return false;
  }
}

template <typename Number>
void copyNumbers(const matvar_t& variable, std::size_t first, std::vector<double>& values) {
  const auto* const data = static_cast<const Number*>(variable.data) + first;
  std::transform(data, data + values.size(), values.begin(),
                 [](Number number) { return static_cast<double>(number); });
}

/// Uses the data type, because logical and compressed integers are not stored in the type of their
/// class.
bool copyData(const matvar_t& variable, std::size_t first, std::vector<double>& values) {
  switch (variable.data_type) {
    case MAT_T_DOUBLE:
      copyNumbers<double>(variable, first, values);
      return true;
    case MAT_T_SINGLE:
      copyNumbers<float>(variable, first, values);
      return true;
    case MAT_T_INT8:
      copyNumbers<mat_int8_t>(variable, first, values);
      return true;
    case MAT_T_UINT8:
      copyNumbers<mat_uint8_t>(variable, first, values);
      return true;
    case MAT_T_INT16:
      copyNumbers<mat_int16_t>(variable, first, values);
      return true;
    case MAT_T_UINT16:
      copyNumbers<mat_uint16_t>(variable, first, values);
      return true;
    case MAT_T_INT32:
      copyNumbers<mat_int32_t>(variable, first, values);
      return true;
    case MAT_T_UINT32:
      copyNumbers<mat_uint32_t>(variable, first, values);
      return true;
    case MAT_T_INT64:
      copyNumbers<mat_int64_t>(variable, first, values);
      return true;
    case MAT_T_UINT64:
      copyNumbers<mat_uint64_t>(variable, first, values);
      return true;
    default:
      return false;
  }
}

struct Shape {
  std::size_t rows;
  std::size_t columns;
};

/// Row and column vectors both count as a column.
Shape shapeOf(const matvar_t& variable) {
  if (variable.dims[0] == 1) return {variable.dims[1], 1};
  return {variable.dims[0], variable.dims[1]};
}

}  // namespace

MatSource::MatSource(const std::string& path) : path_(path) {
  requireWhole(path);
  const File file = openFile(path);
  const auto add = [this](const matvar_t& variable, const std::string& name,
                          const std::string& field) {
    if (!isNumeric(variable)) return;
    const Shape shape = shapeOf(variable);
    const std::string whole = field.empty() ? name : name + "." + field;
    if (shape.rows > 0 && shape.columns > kMostColumns - all_.size()) {
      throw LogError(
          path_, whole, "makes over " + std::to_string(kMostColumns) + " columns",
          "save each signal as a column, time downwards, and leave out what is no signal");
    }
    for (std::size_t k = 0; k < shape.columns && shape.rows > 0; ++k) {
      all_.push_back({name, field, k, shape.rows});
      names_.push_back(shape.columns == 1 ? whole : whole + "(:," + std::to_string(k + 1) + ")");
    }
  };
  while (const Variable info{Mat_VarReadNextInfo(file.get())}) {
    if (!info->name) continue;
    add(*info, info->name, "");
    if (info->class_type != MAT_C_STRUCT) continue;
    if (info->rank != 2 || info->dims[0] * info->dims[1] != 1) continue;
    const unsigned fields = Mat_VarGetNumberOfFields(info.get());
    char* const* const field_names = Mat_VarGetStructFieldnames(info.get());
    for (unsigned k = 0; k < fields; ++k) {
      const matvar_t* const field = Mat_VarGetStructFieldByName(info.get(), field_names[k], 0);
      if (field) add(*field, info->name, field_names[k]);
    }
  }
  if (names_.empty()) {
    throw LogError(path, "", "has no numeric vectors, matrices or structs of them",
                   "save each signal as a vector; a timeseries as its Time and Data");
  }
}

void MatSource::select(const std::vector<std::size_t>& columns) {
  data_.clear();
  rows_ = row_ = 0;
  for (const std::size_t index : columns) rows_ = std::max(rows_, all_[index].rows);
  const File file = openFile(path_);
  // Columns of one variable are adjacent, so the variable is read once for all of them.
  std::string loaded;
  Variable variable;
  for (const std::size_t index : columns) {
    const Column& column = all_[index];
    if (column.rows != rows_ && column.rows != 1) {
      throw LogError(path_, names_[index],
                     "has " + std::to_string(column.rows) + " values where others have " +
                         std::to_string(rows_),
                     "choose columns of one recording with --column");
    }
    if (!variable || loaded != column.variable) {
      variable.reset(Mat_VarRead(file.get(), column.variable.c_str()));
      loaded = column.variable;
    }
    const matvar_t* numbers = variable.get();
    if (numbers && !column.field.empty()) {
      numbers = Mat_VarGetStructFieldByName(variable.get(), column.field.c_str(), 0);
    }
    // The file stores dimensions separately, so check that there are numbers for them.
    if (!numbers || !numbers->data || numbers->data_size <= 0 ||
        numbers->nbytes / static_cast<std::size_t>(numbers->data_size) / column.rows <=
            column.column) {
      throw LogError(path_, names_[index], "holds less than it claims",
                     "the file is damaged or not whole: copy or save it again");
    }
    std::vector<double> values(column.rows);
    if (!copyData(*numbers, column.column * column.rows, values)) {
      throw LogError(path_, names_[index], "cannot be read", "save the file again");
    }
    data_.push_back(std::move(values));
  }
}

bool MatSource::next(std::vector<double>& values) {
  if (row_ == rows_) return false;
  values.resize(data_.size());
  for (std::size_t k = 0; k < data_.size(); ++k) {
    values[k] = data_[k].size() == 1 ? data_[k][0] : data_[k][row_];
  }
  ++row_;
  return true;
}

}  // namespace cvg
