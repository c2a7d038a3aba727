#include "leadthrough/arm/jacobian.hpp"

#include <Eigen/Geometry>

#include "leadthrough/arm/run_down.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

// A vector and its first two derivatives in time.
struct Motion {
  Eigen::Vector3d value, first, second;
};

// The joints' axes and origins and the tip, all moving in the base frame.
struct MovingChain {
  std::array<Motion, kMaxJoints> axes, origins;
  Motion tip;
};

// Velocities and accelerations, joint after joint, from the moving joints' rates. Without SECOND no
// accelerations.
template <bool SECOND>
void move(const Chain& chain, const double* rates, const double* second_rates,
          MovingChain& moving) {
  const std::size_t n = moving_count(chain);
  Eigen::Vector3d omega = Eigen::Vector3d::Zero();  // the link's angular velocity
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();  // its angular acceleration
  moving.origins[0].first.setZero();
  moving.origins[0].second.setZero();
  for (std::size_t i = 0; i < n; ++i) {
    Motion& axis = moving.axes[i];
    const Motion& origin = moving.origins[i];
    Motion& next = i + 1 < n ? moving.origins[i + 1] : moving.tip;
    axis.first = omega.cross(axis.value);
    if constexpr (SECOND) axis.second = alpha.cross(axis.value) + omega.cross(axis.first);
    if (!chain.prismatic[i]) {
      omega += rates[i] * axis.value;
      if constexpr (SECOND) alpha += second_rates[i] * axis.value + rates[i] * axis.first;
    }
    const Eigen::Vector3d arm = next.value - origin.value;
    Eigen::Vector3d velocity = omega.cross(arm);
    if (chain.prismatic[i]) velocity += rates[i] * axis.value;
    next.first = origin.first + velocity;
    if constexpr (SECOND) {
      next.second = origin.second + alpha.cross(arm) + omega.cross(velocity);
      if (chain.prismatic[i]) next.second += second_rates[i] * axis.value + rates[i] * axis.first;
    }
  }
}

template <bool SECOND>
void differentiate(const Chain& chain, const double* q, const double* qd, const double* qdd,
                   JacobianColumns& derivative) {
  MovingValues values, rates, second_rates;
  MovingChain moving;
  moving.tip.value = run_down(chain, moving_values(chain, q, values),
                              [&](std::size_t i, const auto& axis, const auto& origin) {
                                moving.axes[i].value = axis;
                                moving.origins[i].value = origin;
                              })
                         .position;
  move<SECOND>(chain, moving_rates(chain, qd, rates),
               SECOND ? moving_rates(chain, qdd, second_rates) : nullptr, moving);
  for (std::size_t i = 0; i < moving_count(chain); ++i) {
    const Motion& axis = moving.axes[i];
    const Motion& origin = moving.origins[i];
    const Eigen::Vector3d& angular = SECOND ? axis.second : axis.first;
    if (chain.prismatic[i]) {
      derivative[i] << angular, Eigen::Vector3d::Zero();
      continue;
    }
    const Eigen::Vector3d arm = moving.tip.value - origin.value;
    const Eigen::Vector3d arm_first = moving.tip.first - origin.first;
    Eigen::Vector3d linear;
    if constexpr (SECOND)
      linear = axis.second.cross(arm) + 2.0 * axis.first.cross(arm_first) +
               axis.value.cross(moving.tip.second - origin.second);
    else
      linear = axis.first.cross(arm) + axis.value.cross(arm_first);
    derivative[i] << linear, angular;
  }
  gather(chain, derivative);
}

// A matrix by rows in each row of the result; at_row(i) gives its columns.
template <typename AtRow>
Rows each_row(const Chain& chain, Eigen::Index count, AtRow at_row) {
  const Eigen::Index n = chain.joints();
  Rows result(count, 6 * n);
  for (Eigen::Index row = 0; row < count; ++row) {
    check_interrupt(row);
    const JacobianColumns& columns = at_row(row);
    Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>> matrix(
        result.row(row).data(), 6, n);
    for (Eigen::Index i = 0; i < n; ++i) matrix.col(i) = columns[static_cast<std::size_t>(i)];
  }
  return result;
}

}  // namespace

void jacobian_derivative(const Chain& chain, const double* q, const double* qd,
                         JacobianColumns& derivative) {
  differentiate<false>(chain, q, qd, nullptr, derivative);
}

void jacobian_second_derivative(const Chain& chain, const double* q, const double* qd,
                                const double* qdd, JacobianColumns& derivative) {
  differentiate<true>(chain, q, qd, qdd, derivative);
}

Rows jacobian_batch(const Chain& chain, const RowsRef& q) {
  check_rows(chain, q);
  Kinematics kinematics;
  return each_row(chain, q.rows(), [&](Eigen::Index row) -> const JacobianColumns& {
    forward_kinematics(chain, q.row(row).data(), kinematics);
    return kinematics.jacobian;
  });
}

Rows jacobian_derivative_batch(const Chain& chain, const RowsRef& q, const RowsRef& qd) {
  check_rates(chain, q, {qd});
  JacobianColumns columns;
  return each_row(chain, q.rows(), [&](Eigen::Index row) -> const JacobianColumns& {
    jacobian_derivative(chain, q.row(row).data(), qd.row(row).data(), columns);
    return columns;
  });
}

Rows jacobian_second_derivative_batch(const Chain& chain, const RowsRef& q, const RowsRef& qd,
                                      const RowsRef& qdd) {
  check_rates(chain, q, {qd, qdd});
  JacobianColumns columns;
  return each_row(chain, q.rows(), [&](Eigen::Index row) -> const JacobianColumns& {
    jacobian_second_derivative(chain, q.row(row).data(), qd.row(row).data(), qdd.row(row).data(),
                               columns);
    return columns;
  });
}

}  // namespace leadthrough
