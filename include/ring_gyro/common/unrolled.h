#pragma once

#include <utility>

namespace cvg {

/// Calls work(i) for i = From to To - 1, each i a compile-time constant: a loop over the elements
/// of a small matrix, with no loop left in the program.
template <int From, int To, typename Work>
inline void unrolled(Work&& work) {
  if constexpr (From < To) {
    work(std::integral_constant<int, From>());
    unrolled<From + 1, To>(std::forward<Work>(work));
  }
}

}  // namespace cvg
