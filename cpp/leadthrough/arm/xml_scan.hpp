#pragma once

// A strict, linear and non-recursive reading of an XML document's elements and attributes, done
// before any recursive parser sees the text: depth and size are bounded, and every parser agrees on
// accepted documents.

#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace leadthrough::xml {

struct Bounds {
  std::size_t bytes = std::size_t{16} << 20;
  std::size_t elements = 200'000;
  int depth = 64;
  std::size_t attributes = 64;  // of one element; parsers compare each with all others
};

// Names and values are views into the scanned text, entities as written.
struct Element {
  std::string_view name;
  int parent = -1;  // index into the document's elements; -1 for the root
  int depth = 0;    // 0 for the root
  std::vector<std::pair<std::string_view, std::string_view>> attributes;

  // The value of an attribute, or nullptr.
  const std::string_view* find(std::string_view key) const;
};

using Elements = std::vector<Element>;  // in document order

struct Error {
  std::string where;
  std::string why;
};

// The elements, or the first error.
std::variant<Elements, Error> scan(std::string_view text, const Bounds& bounds = {});

}  // namespace leadthrough::xml
