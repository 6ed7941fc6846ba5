#include "pipeline/formats/nifti_geometry.h"

#include <algorithm>
#include <cmath>

#include "pipeline/formats/grid_axes.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

constexpr double kSameLength = 0.01;      // relative: headers are rounded to a few digits
constexpr double kSameDirection = 0.02;   // difference of unit vectors, about one degree
constexpr double kPlaceholderMm = 1.0;    // what tools write where they know no size
constexpr double kPlaceholderTol = 1e-6;  // float32 holds 1 exactly

Vec3 edges(const Affine& affine) { return affine.linear().colwise().norm().transpose(); }

bool same_lengths(const Vec3& a, const Vec3& b) {
  return ((a - b).array().abs() <= kSameLength * b.array().abs()).all();
}

bool placeholder(const Vec3& edges_mm) {
  return ((edges_mm.array() - kPlaceholderMm).abs() < kPlaceholderTol).all();
}

Affine with_lengths(const Affine& affine, const Vec3& lengths) {
  Affine out = affine;
  for (int c = 0; c < 3; ++c) out.linear().col(c) *= lengths[c] / affine.linear().col(c).norm();
  return out;
}

}  // namespace

Affine flip_lps_ras(const Affine& mm_from_index) {
  return Affine(Eigen::Scaling(-1.0, -1.0, 1.0)) * mm_from_index;
}

Affine lps_from_index(const NiftiGeometry& geometry, std::string& note) {
  const Vec3 pixdim(geometry.pixdim_mm[0], geometry.pixdim_mm[1], geometry.pixdim_mm[2]);
  const bool pixdim_ok = usable_edges(pixdim);
  const bool qform_ok = geometry.has_qform && pixdim_ok && geometry.qform_ras.matrix().allFinite();
  bool sform_ok = geometry.has_sform && geometry.sform_ras.matrix().allFinite() &&
                  usable_edges(edges(geometry.sform_ras));
  if (!pixdim_ok && !sform_ok)
    throw_invalid(
        "the header holds no usable voxel size (pixdim is zero, negative or no number); correct "
        "it");

  Affine ras = Affine::Identity();
  if (sform_ok) {
    const Vec3 sform_edges = edges(geometry.sform_ras);
    if (!pixdim_ok) {
      ras = geometry.sform_ras;
      add_sentence(note, "The voxel sizes in pixdim are unusable, those of the sform were taken.");
    } else if (same_lengths(sform_edges, pixdim)) {
      ras = geometry.sform_ras;
    } else if (placeholder(pixdim) && !placeholder(sform_edges)) {
      ras = geometry.sform_ras;
      add_sentence(note, "pixdim was left at 1 mm, the voxel sizes of the sform were taken.");
    } else if (qform_ok) {
      ras = geometry.qform_ras;
      add_sentence(note, "The sform contradicts the voxel sizes in pixdim, the qform was taken.");
    } else {
      ras = with_lengths(geometry.sform_ras, pixdim);
      add_sentence(
          note,
          "The sform contradicts the voxel sizes in pixdim, its directions were taken with the "
          "sizes of pixdim.");
    }
    if (qform_ok && same_lengths(sform_edges, pixdim)) {
      const Eigen::Matrix3d difference = geometry.sform_ras.linear().colwise().normalized() -
                                         geometry.qform_ras.linear().colwise().normalized();
      if (difference.colwise().norm().maxCoeff() > kSameDirection) {
        add_sentence(note, "sform and qform point in different directions, the sform was taken.");
      }
    }
  } else if (qform_ok) {
    ras = geometry.qform_ras;
  } else {
    ras.linear() = pixdim.asDiagonal();
    add_sentence(
        note, "The file holds no orientation, its axes were taken as right, anterior, superior.");
  }
  return checked_axes(flip_lps_ras(ras), note);
}

}  // namespace beatlas::formats
