#pragma once

// Arrays in an archive as NumPy's `savez` writes it, not compressed: numbers (float64) and texts
// (bytes).

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// The constructor throws std::invalid_argument for a file that cannot be read or is damaged, the
// members for an array that is missing, or of another type or size.
class Npz {
 public:
  explicit Npz(const std::string& path);

  bool has(const std::string& name) const { return members_.count(name) > 0; }
  std::string text(const std::string& name) const;
  double number(const std::string& name) const;
  // Finite numbers (n).
  Eigen::VectorXd vector(const std::string& name) const;
  // Finite numbers (n, columns).
  Rows rows(const std::string& name, Eigen::Index columns) const;
  // Numbers of an array of any shape, in C order; they may be infinite.
  std::vector<double> numbers(const std::string& name) const;

 private:
  template <typename Value>
  Value at(std::uint64_t place) const;
  void add_member(std::uint64_t entry);
  std::string bytes(const std::string& name, const std::string& type) const;
  [[noreturn]] void refuse(const std::string& why) const;

  std::string path_, content_;
  std::map<std::string, std::string> members_;  // headers and numbers of the arrays
};

}  // namespace leadthrough
