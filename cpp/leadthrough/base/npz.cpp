#include "leadthrough/base/npz.hpp"

#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace leadthrough {

namespace {

// Of the archive's parts; APPNOTE.TXT of PKWARE, sections 4.3.7, 4.3.12 and 4.3.16.
constexpr std::uint64_t kLocalHeader = 30, kEntry = 46, kEnd = 22;
constexpr std::uint32_t kEndSignature = 0x06054b50, kEntrySignature = 0x02014b50;

std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = ~0U;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xedb88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

}  // namespace

Npz::Npz(const std::string& path) : path_(path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse("cannot be read");
  content_.assign(std::istreambuf_iterator<char>(file), {});
  if (content_.size() < kEnd) refuse("is no .npz archive");
  const std::uint64_t end = content_.size() - kEnd;
  if (at<std::uint32_t>(end) != kEndSignature) refuse("is no .npz archive, or is damaged");
  std::uint64_t entry = at<std::uint32_t>(end + 16);
  for (int left = at<std::uint16_t>(end + 10); left > 0; --left) {
    add_member(entry);
    entry += kEntry + at<std::uint16_t>(entry + 28) + at<std::uint16_t>(entry + 30) +
             at<std::uint16_t>(entry + 32);
  }
  content_.clear();
}

void Npz::add_member(std::uint64_t entry) {
  if (at<std::uint32_t>(entry) != kEntrySignature) refuse("is damaged");
  if (at<std::uint16_t>(entry + 10) != 0) refuse("is compressed");
  const std::uint64_t size = at<std::uint32_t>(entry + 24), local = at<std::uint32_t>(entry + 42);
  const std::uint64_t begin =
      local + kLocalHeader + at<std::uint16_t>(local + 26) + at<std::uint16_t>(local + 28);
  std::string name = content_.substr(entry + kEntry, at<std::uint16_t>(entry + 28));
  if (begin + size > content_.size()) refuse("is damaged");
  std::string bytes = content_.substr(begin, size);
  if (crc32(bytes) != at<std::uint32_t>(entry + 16)) refuse("is damaged: " + name);
  if (const std::size_t suffix = name.rfind(".npy"); suffix != std::string::npos)
    name.resize(suffix);
  members_[name] = std::move(bytes);
}

template <typename Value>
Value Npz::at(std::uint64_t place) const {
  if (place + sizeof(Value) > content_.size()) refuse("is damaged");
  Value value;
  std::memcpy(&value, content_.data() + place, sizeof(Value));
  return value;
}

// NumPy's format of arrays, version 1: a magic string, the size of a header, which is a dictionary
// of Python, and the numbers.
std::string Npz::bytes(const std::string& name, const std::string& type) const {
  const auto found = members_.find(name);
  if (found == members_.end()) refuse("has no array '" + name + "'");
  const std::string& all = found->second;
  if (all.size() < 10 || all.compare(0, 7, "\x93NUMPY\x01") != 0) refuse("is damaged: " + name);
  std::uint16_t size = 0;
  std::memcpy(&size, all.data() + 8, sizeof(size));
  const std::string header = all.substr(10, size);
  if (header.find("'descr': '" + type + "'") == std::string::npos ||
      header.find("'fortran_order': False") == std::string::npos)
    refuse("has an array of another type: " + name);
  return all.substr(10 + header.size());
}

std::string Npz::text(const std::string& name) const { return bytes(name, "|u1"); }

std::vector<double> Npz::numbers(const std::string& name) const {
  const std::string found = bytes(name, "<f8");
  std::vector<double> result(found.size() / sizeof(double));
  std::memcpy(result.data(), found.data(), result.size() * sizeof(double));
  return result;
}

double Npz::number(const std::string& name) const {
  const Eigen::VectorXd values = vector(name);
  if (values.size() != 1) refuse("expected one number: " + name);
  return values[0];
}

Eigen::VectorXd Npz::vector(const std::string& name) const { return rows(name, 1); }

Rows Npz::rows(const std::string& name, Eigen::Index columns) const {
  const std::vector<double> found = numbers(name);
  const auto count = static_cast<Eigen::Index>(found.size());
  if (columns < 1 || count == 0 || count % columns != 0) refuse("has another size: " + name);
  const Rows result = Eigen::Map<const Rows>(found.data(), count / columns, columns);
  if (!result.allFinite()) refuse("has a number that is not finite: " + name);
  return result;
}

void Npz::refuse(const std::string& why) const { throw std::invalid_argument(path_ + ": " + why); }

}  // namespace leadthrough
