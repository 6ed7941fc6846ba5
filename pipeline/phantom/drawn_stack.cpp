#include "pipeline/phantom/drawn_stack.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace beatlas::phantom {
namespace {

constexpr float kEndSystole = 0.35F;  ///< share of the beat, see contraction_at
constexpr float kLeastField = 180;    ///< [mm] holds the ventricles, and what lies beside them
constexpr int kEnoughPhases = 8;      ///< below it pixels are given up before frames
constexpr int kLeastColumns = 80;

/// [mm] along the normal, from the heart's middle.
struct Extent {
  float low = 0;
  float high = 0;
};

/// Across the LV, from beyond its base to beyond its apex, or not so far.
Extent short_axis_extent(const Family& family, const DrawnHeart& heart) {
  const float base = family.happens("exam_below_base") ? family.number("exam_base_missed")
                                                       : -family.number("exam_above_base");
  const float apex = family.happens("exam_before_apex")
                         ? heart.length() - family.number("exam_apex_missed")
                         : heart.length() + 8 + family.number("exam_beyond_apex");
  return {base - heart.middle().z(), apex - heart.middle().z()};
}

std::vector<float> frame_times(const Family& family, int phases) {
  std::vector<float> out;
  if (phases == 1) return {family.uniform("exam_only_moment") < 0.5F ? 0.0F : 0.75F};
  // Two images are those of the fullest and of the emptiest heart.
  if (phases == 2) return {0.0F, kEndSystole};
  out.reserve(static_cast<std::size_t>(phases));
  for (int p = 0; p < phases; ++p) {
    out.push_back(static_cast<float>(p) / static_cast<float>(phases));
  }
  return out;
}

int drawn_phases(const Family& family) {
  if (family.happens("exam_one_phase")) return 1;
  if (family.happens("exam_few_phases")) {
    return 2 + static_cast<int>(7.99F * family.uniform("exam_few"));
  }
  return static_cast<int>(std::lround(family.number("exam_phases")));
}

/// Pixels, field of view and frames, so that no more than `most` voxels are left.
struct Sampling {
  float field = 0;
  float pixel = 0;
  int phases = 0;
  int slices = 0;

  [[nodiscard]] int columns() const {
    return std::max(kLeastColumns, static_cast<int>(std::lround(field / pixel)));
  }
  /// How many times too many voxels there are.
  [[nodiscard]] float excess(int most) const {
    const auto n = static_cast<float>(columns());
    return n * n * static_cast<float>(slices) * static_cast<float>(phases) /
           static_cast<float>(most);
  }
  void fewer_phases(int most, int least) {
    const float many = excess(most);
    if (many <= 1 || phases <= least) return;
    phases = std::max(least, static_cast<int>(static_cast<float>(phases) / many));
  }
  void larger_pixels(int most, float largest) {
    const float many = excess(most);
    if (many > 1) pixel = std::max(pixel, std::min(largest, pixel * std::sqrt(many) * 1.01F));
  }
  void smaller_field(int most) {
    const float many = excess(most);
    if (many > 1) field = std::max(std::min(field, kLeastField), field / std::sqrt(many) * 0.99F);
  }
};

Sampling sampled(const Family& family, int slices, int most) {
  Sampling out{family.number("exam_field"), family.number("exam_pixel"), drawn_phases(family),
               slices};
  if (family.uniform("exam_frames_first") < 0.5F) out.fewer_phases(most, kEnoughPhases);
  out.larger_pixels(most, 2);
  out.smaller_field(most);
  out.fewer_phases(most, 2);
  return out;
}

/// [mm] Of a slice of the exam along its axes, as its breath was held.
Eigen::Vector2f drawn_shift(const Family& family, int slice) {
  const float spread = family.number("shift");
  const float longest = family.number("exam_shift_limit");
  const auto n = static_cast<std::uint32_t>(slice);
  Eigen::Vector2f shift(spread * family.normal("shift_u", n), spread * family.normal("shift_v", n));
  if (shift.norm() > longest) shift *= longest / shift.norm();
  return shift;
}

}  // namespace

Grid DrawnStack::grid() const {
  Grid out;
  out.size = {columns, columns, slices};
  out.mm_from_index.linear().col(0) = (pixel_mm * u).cast<double>();
  out.mm_from_index.linear().col(1) = (pixel_mm * v).cast<double>();
  out.mm_from_index.linear().col(2) = (distance_mm * normal).cast<double>();
  out.mm_from_index.translation() = seen_at(0, 0, 0, Eigen::Vector2f::Zero()).cast<double>();
  return out;
}

Vec3F DrawnStack::seen_at(float i, float j, float k, const Eigen::Vector2f& shift) const {
  const float half = 0.5F * static_cast<float>(columns - 1);
  return middle + ((i - half) * pixel_mm - shift.x()) * u +
         ((j - half) * pixel_mm - shift.y()) * v +
         (k - 0.5F * static_cast<float>(slices - 1)) * distance_mm * normal;
}

DrawnStack drawn_stack(const Family& family, const DrawnHeart& heart, const Eigen::Matrix3f& axes,
                       int most_voxels) {
  DrawnStack out;
  Extent extent;
  if (family.happens("exam_axial")) {
    out.plane = "axial";
    out.normal =
        Vec3F(0.05F * family.normal("axial_tilt", 0), 0.05F * family.normal("axial_tilt", 1), 1);
  } else if (family.happens("exam_oblique")) {
    out.plane = "oblique";
    out.normal = {family.normal("any", 0), family.normal("any", 1), family.normal("any", 2)};
  } else {
    out.plane = "short_axis";
    const float tilt = family.number("tilt") * kPi / 180;
    out.normal =
        axes * Vec3F(tilt * family.normal("tilted", 0), tilt * family.normal("tilted", 1), 1);
    extent = short_axis_extent(family, heart);
  }
  out.normal.normalize();
  if (out.plane != "short_axis") {
    extent = {-family.number("exam_reach", 0) * heart.reach(),
              family.number("exam_reach", 1) * heart.reach()};
  }
  if (family.happens("exam_thin")) {
    out.thickness_mm = family.number("exam_thin_slice");
    out.distance_mm = out.thickness_mm;
  } else {
    out.thickness_mm = family.number("exam_slice");
    out.distance_mm =
        out.thickness_mm + (family.happens("exam_gapless") ? 0 : family.number("exam_gap"));
  }
  const auto wanted = static_cast<int>((extent.high - extent.low) / out.distance_mm) + 1;
  out.slices = std::clamp(wanted, static_cast<int>(family.number("exam_least_slices")),
                          static_cast<int>(family.number("exam_most_slices")));
  const Sampling sampling = sampled(family, out.slices, most_voxels);
  out.columns = sampling.columns();
  out.pixel_mm = sampling.pixel;
  out.times = frame_times(family, sampling.phases);
  out.rr_interval_s = family.number("exam_rr");

  const Vec3F other = std::abs(out.normal.z()) < 0.9F ? Vec3F::UnitZ() : Vec3F::UnitY();
  const Vec3F across = out.normal.cross(other).normalized();
  out.u = Eigen::AngleAxisf(family.between(0, 2 * kPi, "plane_turn"), out.normal) * across;
  out.v = out.normal.cross(out.u);
  // The view is laid about the ventricles, more or less.
  const Vec3F about =
      axes * (Vec3F(0.5F * heart.middle().x(), 0, 0.5F * heart.length()) - heart.middle());
  const float half = 0.5F * static_cast<float>(out.columns) * out.pixel_mm;
  const float off =
      std::min(family.number("off_centre"), std::max(0.0F, half - 0.5F * kLeastField));
  const float way = family.between(0, 2 * kPi, "off_way");
  out.middle = about - about.dot(out.normal) * out.normal +
               0.5F * (extent.low + extent.high) * out.normal +
               off * (std::cos(way) * out.u + std::sin(way) * out.v);
  if (family.uniform("exam_from_apex") < 0.5F) {
    out.normal = -out.normal;
    out.v = -out.v;
  }
  for (int k = 0; k < out.slices; ++k) out.shifts.push_back(drawn_shift(family, k));
  return out;
}

std::vector<DrawnStack> drawn_views(const Family& family, const DrawnHeart& heart,
                                    const Eigen::Matrix3f& axes, const DrawnStack& stack,
                                    int count) {
  const float tilt = family.number("view_tilt") * kPi / 180;
  const float off = family.number("view_off");
  const Vec3F apex_to_base = -Vec3F::UnitZ();
  std::vector<DrawnStack> out;
  for (int view = 0; view < count; ++view) {
    const auto n = static_cast<std::uint32_t>(view);
    const float turn = kPi * static_cast<float>(view) / static_cast<float>(count);
    const Vec3F along(std::cos(turn), std::sin(turn), 0);
    const Vec3F across = along.cross(apex_to_base);
    DrawnStack slice = stack;
    slice.plane = "long_axis";
    slice.normal = (axes * (across + tilt * family.normal("view_tilt_axis", n) * apex_to_base +
                            tilt * family.normal("view_tilt_turn", n) * along))
                       .normalized();
    slice.u = (axes * along - (axes * along).dot(slice.normal) * slice.normal).normalized();
    slice.v = slice.normal.cross(slice.u);
    slice.middle =
        axes * (Vec3F(0.5F * heart.middle().x(), 0, 0.5F * heart.length()).dot(along) * along +
                0.4F * heart.length() * Vec3F::UnitZ() - heart.middle()) +
        off * family.normal("view_off_way", n) * slice.normal;
    slice.columns =
        std::max(stack.columns, static_cast<int>(std::ceil(2 * heart.reach() / stack.pixel_mm)));
    slice.slices = 1;
    slice.before = stack.slices + view;
    slice.thickness_mm = family.number("exam_slice");
    slice.distance_mm = slice.thickness_mm;
    slice.shifts = {drawn_shift(family, slice.before)};
    out.push_back(slice);
  }
  return out;
}

}  // namespace beatlas::phantom
