#pragma once

#include <stdexcept>

namespace leadthrough {

// Refuses an argument of a public function; `rule` is the condition that was broken.
inline void check_argument(bool holds, const char* rule) {
  if (!holds) throw std::invalid_argument(rule);
}

}  // namespace leadthrough
