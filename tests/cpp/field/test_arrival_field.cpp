#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <type_traits>
#include <vector>

#include "base/cases.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/field/arrival_field.hpp"
#include "leadthrough/field/eikonal.hpp"

namespace leadthrough::arrival_field_tests {

namespace {

// A time kept in a repair may be off by some roundings.
template <typename Real>
constexpr Real kTolerance = std::is_same_v<Real, float> ? Real(1e-5) : Real(1e-9);

template <typename Real>
void expect_equal_to_full_march(ArrivalField<Real>& field, const Grid& grid,
                                const std::vector<Real>& speed,
                                const std::vector<Source>& sources) {
  const auto expected = march_first_order(grid, speed.data(), sources);
  const auto times = field.times();
  for (std::size_t n = 0; n < times.size(); ++n) {
    if (std::isinf(expected[n]))
      ASSERT_EQ(times[n], expected[n]) << n;
    else
      ASSERT_NEAR(times[n], expected[n], kTolerance<Real> * expected[n]) << n;
  }
}

// Random boxes take random speeds, or become walls; sources start at different times.
template <typename Real>
void change_at_random(const Grid& grid, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto pick = [&](Index count) {
    return std::min(static_cast<Index>(uniform(generator) * static_cast<double>(count)), count - 1);
  };
  std::vector<Real> speed(grid.size());
  for (Real& value : speed) value = static_cast<Real>(0.1 + uniform(generator));
  const std::vector<Source> sources{{pick(grid.size()), 0.0}, {pick(grid.size()), 3.0}};
  const auto field = make_arrival_field(grid, speed.data(), sources);
  const auto strides = grid.strides();
  for (int repeat = 0; repeat < 8; ++repeat) {
    Region region{};
    Index size = 1;
    for (int axis = 0; axis < 3; ++axis) {
      region.low[axis] = pick(grid.shape[axis]);
      region.shape[axis] = 1 + pick(grid.shape[axis] - region.low[axis]);
      size *= region.shape[axis];
    }
    const double kind = uniform(generator);
    std::vector<Real> part(size);
    for (Real& value : part)
      value =
          kind < 0.4 ? Real(0) : static_cast<Real>((kind < 0.5 ? 7.0 : 0.1) + uniform(generator));
    std::size_t n = 0;
    for (Index x = 0; x < region.shape[0]; ++x)
      for (Index y = 0; y < region.shape[1]; ++y)
        for (Index z = 0; z < region.shape[2]; ++z, ++n) {
          const Index cell = (region.low[0] + x) * strides[0] + (region.low[1] + y) * strides[1] +
                             region.low[2] + z;
          for (const Source& source : sources)
            if (source.cell == cell) part[n] = Real(1);
          speed[cell] = part[n];
        }
    field->update(region, part.data());
    expect_equal_to_full_march(*field, grid, speed, sources);
  }
}

// Keeps computations of this thread interrupted while it lives.
class Interrupting {
 public:
  Interrupting() {
    try {
      while (true) check_interrupt();
    } catch (const Interrupted&) {
    }
  }

 private:
  Interruptible interruptible_{[] { return true; }};
};

}  // namespace

TEST(ArrivalField, IsMadeWholeAfterAnInterruptedChange) {
  const Grid grid{{1, 60, 60}};
  std::vector<double> speed(grid.size(), 1.0);
  const std::vector<Source> sources{{0}};
  const auto field = make_arrival_field(grid, speed.data(), sources);
  std::fill(speed.begin() + 600, speed.begin() + 1200, 0.25);
  const Region region{{0, 10, 0}, {1, 10, 60}};
  {
    const Interrupting interrupting;
    EXPECT_THROW(field->update(region, speed.data() + 600), Interrupted);
    EXPECT_THROW(field->times(), Interrupted);
  }
  expect_equal_to_full_march(*field, grid, speed, sources);
}

TEST(ArrivalField, EqualsTheFullMarchAfterAnyChanges) {
  const std::vector<Grid> grids{
      {{1, 20, 25}, {1.0, 1.0, 1.5}}, {{9, 8, 10}}, {{1, 1, 30}}, {{6, 1, 7}, {2.0, 0.3, 0.7}}};
  for (const Grid& grid : grids) {
    const int seeds = test::cases(15, 3);
    for (int seed = 0; seed < seeds; ++seed) {
      change_at_random<double>(grid, seed);
      change_at_random<float>(grid, seed);
    }
  }
}

TEST(ArrivalField, RepairsASmallChangeAndMarchesAllForALargeOne) {
  const Grid grid{{1, 60, 60}};
  const std::vector<double> speed(grid.size(), 1.0);
  const auto field = make_arrival_field(grid, speed.data(), {{0, 0.0}});
  const std::vector<double> wall(60, 0.0);
  EXPECT_EQ(field->update({{0, 50, 50}, {1, 4, 4}}, speed.data()).kind, UpdateKind::kNone);
  const auto small = field->update({{0, 50, 50}, {1, 4, 4}}, wall.data());
  EXPECT_EQ(small.kind, UpdateKind::kRepair);
  EXPECT_GE(small.invalidated, 16);
  EXPECT_EQ(field->update({{0, 2, 1}, {1, 1, 59}}, wall.data()).kind, UpdateKind::kFullMarch);
}

}  // namespace leadthrough::arrival_field_tests
