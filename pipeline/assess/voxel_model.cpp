#include "pipeline/assess/voxel_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::assess {
namespace {

constexpr double kFarMm = 20;  // beyond, the distance is clamped, as a field's is

/// Voxels from `low` to `high`, both included.
struct VoxelBox {
  Index3 low{};
  Index3 high{};
};

/// Calls look(i, j, k) for the voxels of a box that are not in another, which lies in it.
template <class Look>
void for_each_new(const VoxelBox& box, const VoxelBox& old, const Look& look) {
  for (int k = box.low[2]; k <= box.high[2]; ++k) {
    for (int j = box.low[1]; j <= box.high[1]; ++j) {
      const bool old_row =
          k >= old.low[2] && k <= old.high[2] && j >= old.low[1] && j <= old.high[1];
      for (int i = box.low[0]; i <= box.high[0]; ++i) {
        if (old_row && i == old.low[0]) i = old.high[0] + 1;
        if (i <= box.high[0]) look(i, j, k);
      }
    }
  }
}

}  // namespace

VoxelModel::VoxelModel(std::shared_ptr<const LabelCycle> labels, Structure structure,
                       const Affine& workspace_from_lps, double rr_interval_s,
                       double stiffness_n_per_m)
    : labels_(std::move(labels)),
      structure_(structure),
      rr_interval_s_(rr_interval_s),
      stiffness_n_per_m_(stiffness_n_per_m) {
  if (!labels_ || labels_->phases.empty()) throw_invalid("there are no labels to touch");
  const Affine workspace_from_index = workspace_from_lps * labels_->grid.mm_from_index;
  index_from_workspace_ = workspace_from_index.inverse();
  spacing_mm_ = labels_->grid.spacing_mm();
  workspace_axes_ = workspace_from_index.linear() * spacing_mm_.cwiseInverse().asDiagonal();
}

bool VoxelModel::inside(int i, int j, int k, std::size_t phase) const {
  const Grid& grid = labels_->grid;
  return grid.contains(i, j, k) &&
         label_in_structure(labels_->phases[phase][grid.offset(i, j, k)], structure_);
}

VoxelModel::Foot VoxelModel::foot(const Vec3& index, std::size_t phase) const {
  const Index3 centre{static_cast<int>(std::lround(index.x())),
                      static_cast<int>(std::lround(index.y())),
                      static_cast<int>(std::lround(index.z()))};
  const bool is_inside = inside(centre[0], centre[1], centre[2], phase);
  double best = kFarMm;
  Vec3 way = Vec3::Zero();  // to the nearest point of a voxel of the other kind, along i, j, k [mm]
  const auto look = [&](int i, int j, int k) {
    if (inside(i, j, k, phase) == is_inside) return;
    Vec3 to;
    const std::array<int, 3> voxel{i, j, k};
    for (int axis = 0; axis < 3; ++axis) {
      const double at = voxel[static_cast<std::size_t>(axis)];
      to[axis] = (std::clamp(index[axis], at - 0.5, at + 0.5) - index[axis]) * spacing_mm_[axis];
    }
    if (to.norm() < best) {
      best = to.norm();
      way = to;
    }
  };
  // Boxes of voxels that grow by the same length along each axis, only their new voxels looked at.
  const double step = spacing_mm_.minCoeff();
  VoxelBox looked_at{centre, centre};
  for (double reach = step; reach - step < best; reach += step) {
    VoxelBox box;
    for (std::size_t a = 0; a < 3; ++a) {
      const int r = static_cast<int>(std::ceil(reach / spacing_mm_[static_cast<Eigen::Index>(a)]));
      box.low[a] = centre[a] - r;
      box.high[a] = centre[a] + r;
    }
    for_each_new(box, looked_at, look);
    looked_at = box;
  }
  Foot out;
  out.distance_mm = is_inside ? -best : best;
  if (way.norm() > 0) out.normal = workspace_axes_ * way.normalized() * (is_inside ? 1.0 : -1.0);
  return out;
}

haptics::Contact VoxelModel::contact(const Vec3& x, double t_s) const {
  const auto phases = static_cast<double>(labels_->phases.size());
  const double beats = t_s / rr_interval_s_;
  const double s = (beats - std::floor(beats)) * phases;
  const double frame = std::min(std::floor(s), phases - 1);
  const double share = s - frame;
  const auto first = static_cast<std::size_t>(frame);
  const Vec3 index = index_from_workspace_ * x;
  const Foot a = foot(index, first);
  const Foot b = foot(index, (first + 1) % labels_->phases.size());
  haptics::Contact out;
  out.force_n =
      (1 - share) * haptics::contact_force_n(stiffness_n_per_m_, a.distance_mm, a.normal) +
      share * haptics::contact_force_n(stiffness_n_per_m_, b.distance_mm, b.normal);
  out.distance_mm = (1 - share) * a.distance_mm + share * b.distance_mm;
  out.depth_mm = 1e3 * out.force_n.norm() / stiffness_n_per_m_;
  out.touching = out.depth_mm > 0;
  const Vec3 mixed = out.touching ? out.force_n : Vec3((1 - share) * a.normal + share * b.normal);
  out.normal = mixed.norm() > 0 ? Vec3(mixed.normalized()) : a.normal;
  out.proxy_mm = x + out.depth_mm * out.normal;
  return out;
}

MakeTouch touch_of(std::shared_ptr<const VoxelModel> model) {
  return [model] { return [model](const Vec3& x, double t) { return model->contact(x, t); }; };
}

}  // namespace beatlas::assess
