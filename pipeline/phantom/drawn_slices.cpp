#include "pipeline/phantom/drawn_slices.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "pipeline/phantom/drawn_body.h"
#include "pipeline/phantom/drawn_heart.h"
#include "pipeline/phantom/drawn_signal.h"

namespace beatlas::phantom {
namespace {

constexpr int kMoments = 6;

struct Plane {
  Vec3F centre = Vec3F::Zero();
  Vec3F u = Vec3F::UnitX();
  Vec3F v = Vec3F::UnitY();
  Vec3F normal = Vec3F::UnitZ();

  [[nodiscard]] Plane moved(const Vec3F& by) const { return {centre + by, u, v, normal}; }
};

}  // namespace

float contraction_at(float time) {
  const auto ease = [](float t) { return t * t * (3 - 2 * t); };
  if (time < 0.35F) return ease(time / 0.35F);
  if (time < 0.55F) return 1 - 0.75F * ease((time - 0.35F) / 0.2F);
  if (time < 0.85F) return 0.25F - 0.07F * (time - 0.55F) / 0.3F;
  return 0.18F * (1 - ease((time - 0.85F) / 0.15F));
}

Eigen::Matrix3f heart_axes(const Family& family) {
  Vec3F z = Vec3F(0.65F, -0.5F, -0.55F).normalized();
  Vec3F x(-0.6F, -0.75F, 0.1F);
  x = (x - x.dot(z) * z).normalized();
  Eigen::Matrix3f axes;
  axes << x, z.cross(x), z;
  const float turn = family.number("heart_turn") * kPi / 180;
  for (std::uint32_t a = 0; a < 3; ++a) {
    const Vec3F about = Vec3F::Unit(static_cast<Eigen::Index>(a));
    axes = axes * Eigen::AngleAxisf(turn * family.normal("heart_turned", a), about);
  }
  return axes;
}

namespace {

/// Height of a short-axis slice over the base: base and apex are where it is hard to tell.
float short_axis_height(const Family& family, float length) {
  const float kind = family.uniform("height_kind");
  const float u = family.uniform("height");
  if (kind < 0.12F) return -45 + 37 * u;
  if (kind < 0.36F) return -8 + 20 * u;
  if (kind < 0.68F) return 12 + (0.7F * length - 12) * u;
  if (kind < 0.94F) return length * (0.7F + 0.3F * u) + 6 * u;
  return length + 3 + 20 * u;
}

Plane draw_plane(const Family& family, const DrawnHeart& heart, const Eigen::Matrix3f& axes) {
  const float kind = family.uniform("plane_kind");
  // The chances of the other planes are drawn one after the other; what is left is short axis.
  Vec3F normal;
  Vec3F centre = Vec3F::Zero();
  if (family.happens("long_axis_plane")) {
    const float angle = family.between(0, kPi, "long_axis_angle");
    normal =
        axes * Vec3F(std::cos(angle), std::sin(angle), 0.15F * family.normal("long_axis_tilt"));
    centre = axes * (Vec3F(0, 0, 0.4F * heart.length()) - heart.middle());
    centre += normal.normalized() * 8 * family.normal("long_axis_off");
  } else if (family.happens("axial_plane")) {
    normal =
        Vec3F(0.05F * family.normal("axial_tilt", 0), 0.05F * family.normal("axial_tilt", 1), 1);
    centre = family.number("axial_height") * heart.reach() * normal;
  } else if (family.happens("any_plane")) {
    normal = {family.normal("any", 0), family.normal("any", 1), family.normal("any", 2)};
    centre = (2 * kind - 1) * 0.45F * heart.reach() * normal.normalized();
  } else {
    const float tilt = family.number("tilt") * kPi / 180;
    normal = axes * Vec3F(tilt * family.normal("tilted", 0), tilt * family.normal("tilted", 1), 1);
    const float height = short_axis_height(family, heart.length());
    centre = axes * (Vec3F(0.25F * heart.middle().x(), 0, height) - heart.middle());
  }
  normal.normalize();
  Plane out;
  out.normal = normal;
  const Vec3F other = std::abs(normal.z()) < 0.9F ? Vec3F::UnitZ() : Vec3F::UnitY();
  const Vec3F u = normal.cross(other).normalized();
  const float turn = family.between(0, 2 * kPi, "plane_turn");
  out.u = Eigen::AngleAxisf(turn, normal) * u;
  out.v = normal.cross(out.u);
  const float off = family.number(family.happens("far_off") ? "far_off_centre" : "off_centre");
  const float way = family.between(0, 2 * kPi, "off_way");
  out.centre = centre + off * (std::cos(way) * out.u + std::sin(way) * out.v);
  return out;
}

/// Draws the tissues of planes; what does not beat is looked up once a plane.
class Cutter {
 public:
  Cutter(const Family& family, const DrawnHeart& heart, const DrawnBody& body,
         const Eigen::Matrix3f& axes)
      : heart_(heart),
        body_(body),
        to_heart_(axes.transpose()),
        thickness_(family.number("slice_thickness")),
        has_heart_(!family.happens("no_heart")) {}

  /// Tissues of every pixel at its centre, and of two places beside it a third of the slice's
  /// thickness off, before the heart is painted.
  [[nodiscard]] TissueImage still(const Plane& plane) const {
    TissueImage out;
    each(plane, [&](std::size_t at, int sub, const Vec3F& lps) {
      out[static_cast<std::size_t>(sub)][at] = body_.at(lps);
    });
    return out;
  }

  void paint_heart(const Plane& plane, float contraction, TissueImage& image) const {
    if (!has_heart_) return;
    const DrawnHeart::Moment moment = heart_.moment(contraction);
    const float reach2 = heart_.reach() * heart_.reach();
    each(plane, [&](std::size_t at, int sub, const Vec3F& lps) {
      if (lps.squaredNorm() > reach2) return;
      const Tissue tissue = heart_.at(to_heart_ * lps + heart_.middle(), moment);
      if (tissue != Tissue::Outside) image[static_cast<std::size_t>(sub)][at] = tissue;
    });
  }

 private:
  template <class Body>
  void each(const Plane& plane, const Body& body) const {
    constexpr std::array<std::array<float, 3>, 3> kSub{
        {{0, 0, 0}, {0.3F, -0.2F, 1.0F / 3}, {-0.3F, 0.2F, -1.0F / 3}}};
    for (int sub = 0; sub < 3; ++sub) {
      const auto& off = kSub[static_cast<std::size_t>(sub)];
      const Vec3F base = plane.centre + off[2] * thickness_ * plane.normal;
      std::size_t at = 0;
      for (int j = 0; j < kDrawnPixels; ++j) {
        const float y = (static_cast<float>(j) + off[1] + 0.5F - kDrawnPixels / 2) * kDrawnPixelMm;
        for (int i = 0; i < kDrawnPixels; ++i, ++at) {
          const float x =
              (static_cast<float>(i) + off[0] + 0.5F - kDrawnPixels / 2) * kDrawnPixelMm;
          body(at, sub, base + x * plane.u + y * plane.v);
        }
      }
    }
  }

  const DrawnHeart& heart_;
  const DrawnBody& body_;
  Eigen::Matrix3f to_heart_;
  float thickness_;
  bool has_heart_;
};

}  // namespace

std::vector<DrawnSample> drawn_samples(std::uint32_t seed) {
  const Ranges ranges =
      Family(seed, Purpose::Training).happens("usual_exam") ? Ranges::Usual : Ranges::Whole;
  const Family family(seed, Purpose::Training, ranges);
  const DrawnHeart heart(family);
  const DrawnBody body(family, heart.reach());
  const Eigen::Matrix3f axes = heart_axes(family);
  const Plane plane = draw_plane(family, heart, axes);
  const Cutter cutter(family, heart, body, axes);

  // Most exams show the beat, some two moments of it, some one.
  const float shown = family.uniform("moments_shown");
  const int moments = shown < 0.06F ? 1 : shown < 0.18F ? 2 : kMoments;
  const float start = family.uniform("first_moment");
  std::vector<float> contractions;
  for (int m = 0; m < moments; ++m) {
    const float time =
        moments == 2 ? 0.35F * static_cast<float>(m) : (static_cast<float>(m) + start) / kMoments;
    contractions.push_back(contraction_at(moments == 1 ? start : time));
  }
  const TissueImage still = cutter.still(plane);
  std::vector<TissueImage> frames(contractions.size(), still);
  for (std::size_t m = 0; m < frames.size(); ++m) {
    cutter.paint_heart(plane, contractions[m], frames[m]);
  }
  const float gap = family.happens("wide_gap") ? family.number("neighbour_gap_wide")
                                               : family.number("neighbour_gap");
  const float shift = family.number("shift");
  std::array<Plane, 2> beside;
  std::array<TissueImage, 2> still_beside;
  const float first_way = family.uniform("below_is_apical") < 0.5F ? 1.0F : -1.0F;
  for (std::uint32_t b = 0; b < 2; ++b) {
    const float way = b == 0 ? first_way : -first_way;
    beside[b] =
        plane.moved(way * gap * plane.normal + shift * family.normal("shift_u", b) * plane.u +
                    shift * family.normal("shift_v", b) * plane.v);
    still_beside[b] = cutter.still(beside[b]);
  }
  std::vector<DrawnSample> out;
  const std::size_t count = std::min<std::size_t>(frames.size(), 3);
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t shown_frame = (n * frames.size()) / count;
    std::array<TissueImage, 2> neighbours = still_beside;
    for (std::size_t b = 0; b < 2; ++b) {
      cutter.paint_heart(beside[b], contractions[shown_frame], neighbours[b]);
    }
    const Family image(seed * 3 + static_cast<std::uint32_t>(n), Purpose::Training, ranges);
    out.push_back(imaged(image, frames, shown_frame, neighbours));
  }
  return out;
}

}  // namespace beatlas::phantom
