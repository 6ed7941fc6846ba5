#include "pipeline/formats/grid_axes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/SVD>

#include "runtime/base/error.h"

namespace beatlas::formats {

bool usable_edges(const Vec3& edges_mm) {
  return edges_mm.allFinite() && edges_mm.minCoeff() >= kLeastEdgeMm &&
         edges_mm.maxCoeff() <= kMostEdgeMm;
}

void add_sentence(std::string& note, const std::string& sentence) {
  if (!note.empty()) note += ' ';
  note += sentence;
}

Affine checked_axes(const Affine& mm_from_index, std::string& note) {
  const Eigen::Matrix3d linear = mm_from_index.linear();
  const Vec3 edges = linear.colwise().norm().transpose();
  if (!usable_edges(edges)) {
    throw_invalid("its voxel size is zero or no length that can be; correct its header");
  }
  const Vec3 place = mm_from_index.translation();
  if (!place.allFinite() || place.cwiseAbs().maxCoeff() > kMostPlaceMm) {
    throw_invalid("its place in the patient is no place that can be; correct its header");
  }
  const Eigen::Matrix3d unit = linear.colwise().normalized();
  const double skew =
      std::max({std::abs(unit.col(0).dot(unit.col(1))), std::abs(unit.col(0).dot(unit.col(2))),
                std::abs(unit.col(1).dot(unit.col(2)))});
  if (!(skew < kShear)) {
    throw_invalid("the axes of its grid are not at right angles; resample it to a straight grid");
  }
  if (skew <= kSkew) return mm_from_index;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(unit, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Affine out = mm_from_index;
  out.linear() = svd.matrixU() * svd.matrixV().transpose() * edges.asDiagonal();
  add_sentence(note, "The axes of its grid were not quite at right angles; they were made so.");
  return out;
}

}  // namespace beatlas::formats
