#pragma once

// Numbers for the cubes of cells that configurations lie in (FNV-1a over whole coordinates).

#include <cmath>
#include <cstdint>

#include "leadthrough/path/tip_task.hpp"

namespace leadthrough::path {

inline std::uint64_t mixed(std::uint64_t hash, long value) {
  return (hash ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(value))) * 0x100000001b3U;
}

// The cell of a configuration, of a size in rad or m; full revolutions are ignored.
inline std::uint64_t cell_of(const Chain& chain, const JointArray& q, double size) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (std::size_t i = 0; i < static_cast<std::size_t>(chain.joints()); ++i) {
    const double value = chain.periodic[i] ? std::remainder(q[i], kTurn) : q[i];
    hash = mixed(hash, std::lround(value / size));
  }
  return hash;
}

}  // namespace leadthrough::path
