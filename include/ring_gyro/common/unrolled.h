#pragma once

#include <utility>

namespace cvg {

/// Calls work(i) for i = From to To - 1, where each i is a compile-time constant: an unrolled loop
/// over the elements of a small matrix.
template <int From, int To, typename Work>
inline void unrolled(Work&& work) {
  if constexpr (From < To) {
    work(std::integral_constant<int, From>());
    unrolled<From + 1, To>(std::forward<Work>(work));
  }
}

}  // namespace cvg
