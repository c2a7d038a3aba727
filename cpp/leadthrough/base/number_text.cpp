#include "leadthrough/base/number_text.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

using Eigen::Index;

// Numbers between these are written without an exponent, as Python writes them.
constexpr double kMinFixed = 1e-4, kMaxFixed = 1e16;
constexpr double kMaxInteger = 9e18;

void append_integer(std::string& out, double value) {
  std::array<char, 24> buffer{};
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), static_cast<std::int64_t>(value));
  out.append(buffer.data(), end.ptr);
}

// The digits always have a point: YAML takes 1e-05 for text.
void append_number(std::string& out, double value) {
  std::array<char, 40> buffer{};
  const double size = std::abs(value);
  const bool fixed = size == 0.0 || (size >= kMinFixed && size < kMaxFixed);
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 fixed ? std::chars_format::fixed : std::chars_format::scientific);
  const std::string_view text(buffer.data(), static_cast<std::size_t>(end.ptr - buffer.data()));
  const std::size_t digits = std::min(text.find('e'), text.size());
  out.append(text.substr(0, digits));
  if (text.find('.') == std::string_view::npos && std::isfinite(value)) out.append(".0");
  out.append(text.substr(digits));
}

class Reader {
 public:
  Reader(std::string_view text, const RecordLayout& layout) : rest_(text), layout_(layout) {}

  // Appends the row that the text begins with, or leaves text and values; whether there was one.
  bool read(std::vector<double>& values) {
    const std::string_view before = rest_;
    const std::size_t kept = values.size();
    if (read_groups(values)) return true;
    rest_ = before;
    values.resize(kept);
    return false;
  }

  std::size_t left() const { return rest_.size(); }

 private:
  bool read_groups(std::vector<double>& values) {
    for (std::size_t group = 0; group < layout_.counts.size(); ++group) {
      if (!skip(layout_.texts[group])) return false;
      for (Index k = 0; k < layout_.counts[group]; ++k) {
        double value = 0.0;
        if ((k > 0 && !skip(layout_.separator)) || !number(value)) return false;
        values.push_back(value);
      }
    }
    return skip(layout_.texts.back());
  }

  bool skip(std::string_view text) {
    if (rest_.substr(0, text.size()) != text) return false;
    rest_.remove_prefix(text.size());
    return true;
  }

  bool number(double& value) {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(' '), rest_.size()));
    const char* end = rest_.data() + rest_.size();
    const auto found = std::from_chars(rest_.data(), end, value);
    if (found.ec != std::errc() || !std::isfinite(value)) return false;
    rest_.remove_prefix(static_cast<std::size_t>(found.ptr - rest_.data()));
    return true;
  }

  std::string_view rest_;
  const RecordLayout& layout_;
};

}  // namespace

std::string write_records(const RowsRef& values, const RecordLayout& layout) {
  Index width = 0;
  for (const Index count : layout.counts) width += count;
  check_argument(layout.texts.size() == layout.counts.size() + 1 && values.cols() == width,
                 "layout: expected a text around each group, and a number for each column");
  std::string out;
  for (Index i = 0; i < values.rows(); ++i) {
    check_interrupt(i);
    Index column = 0;
    for (std::size_t group = 0; group < layout.counts.size(); ++group) {
      out += layout.texts[group];
      for (Index k = 0; k < layout.counts[group]; ++k, ++column) {
        if (k > 0) out += layout.separator;
        if (column >= width - layout.integers && std::abs(values(i, column)) < kMaxInteger)
          append_integer(out, values(i, column));
        else
          append_number(out, values(i, column));
      }
    }
    out += layout.texts.back();
  }
  return out;
}

Records read_records(std::string_view text, const RecordLayout& layout) {
  check_argument(layout.texts.size() == layout.counts.size() + 1 && !layout.texts.back().empty(),
                 "layout: expected a text around each group, the last not empty");
  Records found;
  Reader reader(text, layout);
  Index count = 0;
  while (reader.read(found.values)) check_interrupt(++count);
  found.length = text.size() - reader.left();
  return found;
}

}  // namespace leadthrough
