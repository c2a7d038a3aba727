#pragma once

// Rigid transforms.

#include <Eigen/Geometry>

namespace leadthrough {

// Maps a point of the child frame into the parent frame: rotation * point + position.
struct Transform {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

inline Transform operator*(const Transform& a, const Transform& b) {
  return {a.rotation * b.rotation, a.rotation * b.position + a.position};
}

inline Transform inverse(const Transform& transform) {
  return {transform.rotation.transpose(), -(transform.rotation.transpose() * transform.position)};
}

}  // namespace leadthrough
