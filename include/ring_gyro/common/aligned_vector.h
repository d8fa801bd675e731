#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace cvg {

/// Allocates at the width of the widest vector register, so that no load of the kernels crosses a
/// cache line.
template <typename T>
struct RegisterAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};

  RegisterAllocator() = default;
  template <typename U>
  // NOLINTNEXTLINE(google-explicit-constructor): containers convert their allocators
  RegisterAllocator(const RegisterAllocator<U>&) {}

  T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new(count * sizeof(T), kAlignment));
  }
  void deallocate(T* memory, std::size_t) { ::operator delete(memory, kAlignment); }
};
template <typename T, typename U>
bool operator==(const RegisterAllocator<T>&, const RegisterAllocator<U>&) {
  return true;
}
template <typename T, typename U>
bool operator!=(const RegisterAllocator<T>&, const RegisterAllocator<U>&) {
  return false;
}

/// Samples for the kernels of vector_kernels.h.
using AlignedVector = std::vector<double, RegisterAllocator<double>>;

}  // namespace cvg
