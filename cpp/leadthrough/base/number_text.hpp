#pragma once

// Rows of numbers as text between fixed texts, such as the lines of a table or the points of a JSON
// document: written to the last digit, and read back in blocks.

#include <string>
#include <string_view>
#include <vector>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// A row is texts[0], counts[0] numbers, texts[1], counts[1] numbers, ..., the last text.
struct RecordLayout {
  std::vector<std::string> texts;
  std::vector<Eigen::Index> counts;  // one fewer than texts
  std::string separator;             // between the numbers of a group
  Eigen::Index integers = 0;         // so many of a row's last numbers are integers
};

// The rows of `values`, a column a number. Numbers are the shortest that read back to the same
// bits.
std::string write_records(const RowsRef& values, const RecordLayout& layout);

struct Records {
  std::vector<double> values;  // of all rows, one after the other
  std::size_t length = 0;      // of the text that was read
};

// The rows at the beginning of a text, up to the first that has another layout or that ends beyond
// the text. Spaces may stand before numbers; a number that is not finite has another layout.
Records read_records(std::string_view text, const RecordLayout& layout);

}  // namespace leadthrough
