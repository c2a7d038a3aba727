#include "leadthrough/arm/xml_scan.hpp"

#include <algorithm>

namespace leadthrough::xml {

namespace {

constexpr std::string_view kSpace = " \t\r\n";

bool is_space(char c) { return kSpace.find(c) != std::string_view::npos; }

bool starts_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == ':' ||
         static_cast<unsigned char>(c) >= 0x80;
}

bool continues_name(char c) {
  return starts_name(c) || (c >= '0' && c <= '9') || c == '-' || c == '.';
}

class Scanner {
 public:
  Scanner(std::string_view text, const Bounds& bounds) : text_(text), bounds_(bounds) {}

  std::variant<Elements, Error> run() {
    if (text_.size() > bounds_.bytes)
      return Error{"document", "larger than " + std::to_string(bounds_.bytes >> 20) + " MiB"};
    if (text_.find('\0') != std::string_view::npos)
      return Error{"document", "contains a zero byte"};
    if (starts_with("\xEF\xBB\xBF")) at_ += 3;
    while (failure_.empty() && next_markup()) markup();
    if (failure_.empty() && !open_.empty())
      fail("<" + std::string(elements_[open_.back()].name) + "> is never closed");
    if (failure_.empty() && elements_.empty()) fail("no element");
    if (!failure_.empty()) return Error{"line " + std::to_string(line()), failure_};
    return std::move(elements_);
  }

 private:
  bool starts_with(std::string_view token) const {
    return text_.substr(at_, token.size()) == token;
  }

  void fail(std::string why) {
    if (failure_.empty()) failure_ = std::move(why);
  }

  std::ptrdiff_t line() const {
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size()));
    return 1 + std::count(text_.begin(), end, '\n');
  }

  // Moves to the next '<'; text outside the root element is an error.
  bool next_markup() {
    const std::size_t end = std::min(text_.find('<', at_), text_.size());
    if (open_.empty() && text_.substr(at_, end - at_).find_first_not_of(kSpace) != text_.npos) {
      fail("text outside of any element");
      return false;
    }
    at_ = end;
    return at_ < text_.size();
  }

  void markup() {
    if (starts_with("<!--")) return skip("<!--", "-->", "");
    if (starts_with("<![CDATA[")) return skip("<![CDATA[", "]]>", "");
    if (starts_with("<?")) return skip("<?", "?>", "<>");
    if (starts_with("<!")) return skip("<!", ">", "<[");
    if (starts_with("</")) return close_element();
    open_element();
  }

  // `forbidden` characters inside would be read differently by lenient parsers.
  void skip(std::string_view opening, std::string_view closing, std::string_view forbidden) {
    const std::size_t start = at_ + opening.size();
    const std::size_t end = text_.find(closing, start);
    if (end == text_.npos) return fail("'" + std::string(opening) + "' is never closed");
    if (text_.substr(start, end - start).find_first_of(forbidden) != text_.npos)
      return fail("unsupported markup in '" + std::string(opening) + "'");
    at_ = end + closing.size();
  }

  std::string_view name() {
    const std::size_t start = at_;
    if (at_ < text_.size() && starts_name(text_[at_]))
      while (at_ < text_.size() && continues_name(text_[at_])) ++at_;
    if (at_ == start) fail("expected a name");
    return text_.substr(start, at_ - start);
  }

  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }

  void close_element() {
    at_ += 2;
    const std::string_view closed = name();
    skip_space();
    if (!failure_.empty()) return;
    if (!starts_with(">")) return fail("</" + std::string(closed) + " lacks its '>'");
    if (open_.empty() || elements_[open_.back()].name != closed)
      return fail("</" + std::string(closed) + "> closes nothing that is open");
    ++at_;
    open_.pop_back();
  }

  void open_element() {
    ++at_;
    Element element;
    element.name = name();
    element.parent = open_.empty() ? -1 : static_cast<int>(open_.back());
    element.depth = static_cast<int>(open_.size());
    if (!failure_.empty()) return;
    if (element.parent < 0 && !elements_.empty()) return fail("a second root element");
    if (element.depth >= bounds_.depth)
      return fail("elements are nested deeper than " + std::to_string(bounds_.depth));
    if (elements_.size() >= bounds_.elements)
      return fail("more than " + std::to_string(bounds_.elements) + " elements");
    while (attribute(element)) {
    }
    if (!failure_.empty()) return;
    const bool empty = starts_with("/");
    if (empty) ++at_;
    if (!starts_with(">")) return fail("<" + std::string(element.name) + " lacks its '>'");
    ++at_;
    if (!empty) open_.push_back(elements_.size());
    elements_.push_back(std::move(element));
  }

  bool attribute(Element& element) {
    const bool separated = at_ < text_.size() && is_space(text_[at_]);
    skip_space();
    if (at_ >= text_.size() || text_[at_] == '/' || text_[at_] == '>') return false;
    if (!separated) fail("expected a space before an attribute");
    const std::string_view key = name();
    skip_space();
    if (failure_.empty() && !starts_with("="))
      fail("attribute '" + std::string(key) + "' lacks its '='");
    if (!failure_.empty()) return false;
    ++at_;
    skip_space();
    const char quote = at_ < text_.size() ? text_[at_] : ' ';
    const std::size_t start = at_ + 1;
    const std::size_t end = quote == '"' || quote == '\'' ? text_.find(quote, start) : text_.npos;
    if (end == text_.npos) {
      fail("attribute '" + std::string(key) + "' lacks its quotes");
      return false;
    }
    const std::string_view value = text_.substr(start, end - start);
    if (value.find('<') != value.npos) fail("'<' in attribute '" + std::string(key) + "'");
    if (element.find(key) != nullptr) fail("attribute '" + std::string(key) + "' appears twice");
    if (element.attributes.size() >= bounds_.attributes)
      fail("an element has more than " + std::to_string(bounds_.attributes) + " attributes");
    element.attributes.emplace_back(key, value);
    at_ = end + 1;
    return failure_.empty();
  }

  std::string_view text_;
  const Bounds& bounds_;
  std::size_t at_ = 0;
  std::string failure_;
  std::vector<std::size_t> open_;
  Elements elements_;
};

}  // namespace

const std::string_view* Element::find(std::string_view key) const {
  for (const auto& [own, value] : attributes)
    if (own == key) return &value;
  return nullptr;
}

std::variant<Elements, Error> scan(std::string_view text, const Bounds& bounds) {
  return Scanner(text, bounds).run();
}

}  // namespace leadthrough::xml
