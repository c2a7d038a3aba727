#pragma once

// The layout of Eigen's types, as the library was compiled with it. A program whose types have
// another alignment (-mavx2 in spite of the package's -mno-avx) or another index would crash: it
// does not link, and the message has this name.

#include <Eigen/Core>
#include <cstddef>

namespace leadthrough {

template <std::size_t alignment, std::size_t index>
struct EigenOfProgram {
  static const char differs_from_that_of_leadthrough;
};

[[gnu::used]] static const char* const kLayout =
    &EigenOfProgram<EIGEN_MAX_ALIGN_BYTES, sizeof(Eigen::Index)>::differs_from_that_of_leadthrough;

}  // namespace leadthrough
