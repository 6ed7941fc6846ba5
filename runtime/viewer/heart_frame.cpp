#include "runtime/viewer/heart_frame.h"

#include <algorithm>
#include <limits>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

#include "runtime/base/error.h"

namespace beatlas::viewer {
namespace {

struct Shape {
  Vec3 centre = Vec3::Zero();
  Vec3 longest = Vec3::UnitX();
};

Shape shape_of(const atlas::SurfacePayload& surface, int phase) {
  const auto& positions =
      surface.positions[static_cast<std::size_t>(phase) % surface.positions.size()];
  Shape shape;
  // Weighted by area, so that the triangles' sizes do not matter.
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  double whole = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3 x = positions[a].cast<double>();
    const Vec3 y = positions[b].cast<double>();
    const Vec3 z = positions[c].cast<double>();
    const double area = 0.5 * (y - x).cross(z - x).norm();
    const Vec3 middle = (x + y + z) / 3;
    whole += area;
    shape.centre += area * middle;
    moments += area * middle * middle.transpose();
  }
  if (!(whole > 0)) return shape;
  shape.centre /= whole;
  moments = moments / whole - shape.centre * shape.centre.transpose();
  shape.longest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvectors().col(2);
  return shape;
}

/// The long axis of the map's places, which are told in the first phase: their share rises straight
/// towards the base, so its slope over the places is the direction.
Vec3 apexward_of(const atlas::SurfaceMapPayload& map, const atlas::SurfacePayload& surface) {
  const std::vector<Vec3f>& at = surface.positions.front();
  const auto count = static_cast<double>(at.size());
  Vec3 mean = Vec3::Zero();
  double mean_share = 0;
  for (std::size_t v = 0; v < at.size(); ++v) {
    mean += at[v].cast<double>() / count;
    mean_share += static_cast<double>(map.long_axis[v]) / count;
  }
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Vec3 products = Vec3::Zero();
  for (std::size_t v = 0; v < at.size(); ++v) {
    const Vec3 away = at[v].cast<double>() - mean;
    squares += away * away.transpose();
    products += (static_cast<double>(map.long_axis[v]) - mean_share) * away;
  }
  const Vec3 slope = squares.ldlt().solve(products);
  return slope.norm() > 0 ? Vec3(-slope.normalized()) : Vec3(Vec3::UnitX());
}

Vec3 across(const Vec3& direction, const Vec3& axis) {
  const Vec3 rest = direction - axis.dot(direction) * axis;
  if (rest.norm() > 1e-3) return rest.normalized();
  return axis.unitOrthogonal();
}

}  // namespace

HeartFrame heart_frame(const atlas::Atlas& atlas) {
  HeartFrame frame;
  frame.workspace_from_lps = atlas.manifest().workspace_from_lps;
  frame.low_mm.setConstant(std::numeric_limits<double>::infinity());
  frame.high_mm = -frame.low_mm;
  const atlas::SurfacePayload* left = nullptr;
  for (const Structure structure : kAllStructures) {
    const auto surface = atlas.surface(structure);
    if (!surface) continue;
    if (left == nullptr || structure == Structure::LvBlood) left = surface.get();
    for (const auto& phase : surface->positions) {
      for (const Vec3f& position : phase) {
        frame.low_mm = frame.low_mm.cwiseMin(position.cast<double>());
        frame.high_mm = frame.high_mm.cwiseMax(position.cast<double>());
      }
    }
  }
  if (left == nullptr) {
    throw_invalid("the package has no surfaces to draw; build it with --scene anatomy or full");
  }
  const int phase = atlas.manifest().end_diastole;
  const Shape ventricle = shape_of(*left, phase);
  frame.centre_mm = ventricle.centre;
  // An atlas that knows its long axis is cut along that: short stacks hold LVs wider than long.
  frame.apexward = ventricle.longest;
  if (const auto map = atlas.surface_map(Structure::LvBlood);
      map && left->structure == map->structure) {
    frame.apexward = apexward_of(*map, *left);
  } else if (frame.apexward.dot(frame.lps(1, -1, -1)) < 0)
    frame.apexward *= -1;
  Vec3 right = frame.lps(-1, -1, 0);
  if (const auto surface = atlas.surface(Structure::RvBlood)) {
    right = shape_of(*surface, phase).centre - ventricle.centre;
  }
  frame.to_right = across(right, frame.apexward);
  return frame;
}

Vec3 free_wall_direction(const HeartFrame& frame, const Vec3& heart_centre_mm) {
  return frame.centre_mm - 30 * frame.to_right - heart_centre_mm;
}

CameraPose standard_view(const HeartFrame& frame, std::string_view name) {
  CameraPose pose;
  pose.focus_mm = (frame.low_mm + frame.high_mm) / 2;
  // The whole heart from every side, with some room around it.
  pose.height_mm = 0.82 * (frame.high_mm - frame.low_mm).norm();
  pose.up = frame.lps(0, 0, 1);
  pose.towards_viewer = frame.lps(0, -1, 0);
  if (name == "left") pose.towards_viewer = frame.lps(1, 0, 0);
  if (name == "right") pose.towards_viewer = frame.lps(-1, 0, 0);
  if (name == "posterior") pose.towards_viewer = frame.lps(0, 1, 0);
  if (name == "superior" || name == "inferior") {
    pose.towards_viewer = frame.lps(0, 0, name == "superior" ? 1 : -1);
    pose.up = frame.lps(0, -1, 0);
  }
  if (name == "short-axis" || name == "apex") {
    pose.towards_viewer = frame.apexward;
    pose.up = frame.apexward.cross(-frame.to_right).normalized();
  }
  if (name == "four-chamber") {
    pose.up = frame.apexward;
    pose.towards_viewer = (-frame.to_right).cross(frame.apexward).normalized();
  }
  return pose;
}

CutPlane standard_cut(const HeartFrame& frame, std::string_view name, double offset_mm) {
  CutPlane cut{.point_mm = frame.centre_mm, .normal = frame.lps(0, 0, -1)};
  if (name == "coronal") cut.normal = frame.lps(0, -1, 0);
  if (name == "sagittal") cut.normal = frame.lps(1, 0, 0);
  if (name == "short-axis") cut.normal = frame.apexward;
  if (name == "four-chamber") cut.normal = standard_view(frame, "four-chamber").towards_viewer;
  if (name == "two-chamber") cut.normal = -frame.to_right;
  cut.point_mm += offset_mm * cut.normal;
  return cut;
}

}  // namespace beatlas::viewer
