#include "leadthrough/path/layers.hpp"

#include <algorithm>
#include <cmath>

namespace leadthrough::path {

namespace {

constexpr double kMax = 1e4;  // layers

// Motion of the tip between two rows, in layers.
double steps_between(const TipPath& path, Eigen::Index row, double spacing,
                     double rotation_spacing) {
  const double distance = (path.positions.row(row + 1) - path.positions.row(row)).norm();
  double rotation = 0.0;
  if (path.orientations.rows() > 0) {
    const double cosine = std::abs(path.orientations.row(row).dot(path.orientations.row(row + 1)));
    rotation = 2.0 * std::acos(std::min(cosine, 1.0));
  }
  return distance / spacing + rotation / rotation_spacing;
}

}  // namespace

std::vector<double> layers(const TipPath& path, double spacing, double rotation_spacing) {
  const Eigen::Index rows = path.positions.rows();
  std::vector<double> along(static_cast<std::size_t>(rows), 0.0);
  for (std::size_t i = 1; i < along.size(); ++i)
    along[i] = along[i - 1] +
               steps_between(path, static_cast<Eigen::Index>(i) - 1, spacing, rotation_spacing);
  const double steps = along.back() > 1.0 ? std::min(along.back(), kMax) : 1.0;
  const auto parts = static_cast<std::size_t>(std::ceil(steps));
  std::vector<double> samples{0.0};
  std::size_t row = 0;
  for (std::size_t k = 1; k < parts; ++k) {
    const double at = along.back() * static_cast<double>(k) / static_cast<double>(parts);
    while (along[row + 1] < at) ++row;
    samples.push_back(static_cast<double>(row) + (at - along[row]) / (along[row + 1] - along[row]));
  }
  if (rows > 1) samples.push_back(static_cast<double>(rows - 1));
  return samples;
}

}  // namespace leadthrough::path
