#include "leadthrough/base/layout.hpp"

namespace leadthrough {

template <std::size_t alignment, std::size_t index>
const char EigenOfProgram<alignment, index>::differs_from_that_of_leadthrough = 0;

template struct EigenOfProgram<EIGEN_MAX_ALIGN_BYTES, sizeof(Eigen::Index)>;

}  // namespace leadthrough
