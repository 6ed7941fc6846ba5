#include "pipeline/phantom/drawn_heart.h"

#include <algorithm>
#include <cmath>

#include "runtime/atlas/structures.h"

namespace beatlas::phantom {
namespace {

float degrees(float angle) { return angle * kPi / 180; }

/// cos and sin of an angle less a fixed one.
float turned(float cosine, float sine, float angle) {
  return cosine * std::cos(angle) + sine * std::sin(angle);
}

float hashed(std::int32_t i, std::int32_t j, std::int32_t k, std::uint32_t seed) {
  std::uint32_t h = seed ^ (static_cast<std::uint32_t>(i) * 0x8DA6B343U) ^
                    (static_cast<std::uint32_t>(j) * 0xD8163841U) ^
                    (static_cast<std::uint32_t>(k) * 0xCB1AB31FU);
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 12;
  h *= 0x297A2D39U;
  h ^= h >> 15;
  return static_cast<float>(h) * (2.0F / 4294967295.0F) - 1;
}

float smooth_step(float t) {
  t = std::clamp(t, 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

}  // namespace

float lattice_noise(const Vec3F& at, std::uint32_t seed) {
  const Vec3F floor = at.array().floor();
  const Vec3F t = at - floor;
  const auto i = static_cast<std::int32_t>(floor.x());
  const auto j = static_cast<std::int32_t>(floor.y());
  const auto k = static_cast<std::int32_t>(floor.z());
  const auto row = [&](std::int32_t dj, std::int32_t dk) {
    const float a = hashed(i, j + dj, k + dk, seed);
    return a + t.x() * (hashed(i + 1, j + dj, k + dk, seed) - a);
  };
  const auto layer = [&](std::int32_t dk) {
    const float a = row(0, dk);
    return a + t.y() * (row(1, dk) - a);
  };
  const float a = layer(0);
  return a + t.z() * (layer(1) - a);
}

float lattice_value(const Vec3F& corner, std::uint32_t seed) {
  return hashed(static_cast<std::int32_t>(corner.x()), static_cast<std::int32_t>(corner.y()),
                static_cast<std::int32_t>(corner.z()), seed);
}

std::uint8_t label_of(Tissue tissue) {
  switch (tissue) {
    case Tissue::LvBlood:
    case Tissue::Papillary:
      return kLabelLvBlood;
    case Tissue::LvMuscle:
      return kLabelLvMyocardium;
    case Tissue::RvBlood:
    case Tissue::RvTrabecula:
      return kLabelRvBlood;
    case Tissue::Wall:
    case Tissue::Trunk:
      return kLabelRestOfHeart;
    case Tissue::LaBlood:
      return kLabelLaBlood;
    case Tissue::RaBlood:
      return kLabelRaBlood;
    case Tissue::Aorta:
      return kLabelAorta;
    default:
      return kLabelBackground;
  }
}

DrawnHeart::DrawnHeart(const Family& family) : seed_(family.seed()) {
  bare_ = family.happens("bare");
  size_left(family);
  size_right(family);
  place_beyond(family);
  fat_ = family.number("epicardial_fat");
  groove_fat_ = family.number("groove_fat");
  effusion_ = family.happens("effusion") ? family.number("effusion_depth") : 0;
  pericardium_ = family.number("pericardium");
  // The farthest of apex, RV, atria and great vessels, with what lies about them.
  const Vec3F mid = middle();
  float far = (Vec3F(0, 0, length_ + wall_) - mid).norm();
  far = std::max(far, mid.norm() + radius_ + 2 * wall_ + rv_depth_);
  far = std::max(far, (la_.centre - mid).norm() + 1.35F * la_.axes.maxCoeff());
  far = std::max(far, (ra_.centre - mid).norm() + 1.35F * ra_.axes.maxCoeff());
  for (const auto* tubes : {&outflow_, &aorta_}) {
    for (const Tube& tube : *tubes) far = std::max(far, (tube.to - mid).norm() + tube.radius);
  }
  beside_ = std::max(rv_depth_, 0.45F * rv_depth_ + outflow_[0].radius) + rv_wall_ + 2 * fat_ +
            groove_fat_ + effusion_ + 2 * pericardium_;
  reach_ = far + fat_ + groove_fat_ + effusion_ + 8;
}

void DrawnHeart::size_left(const Family& family) {
  exponent_ = family.number("lv_exponent");
  const float volume = family.number("lv_edv") * 1000;
  const float slenderness = family.number("lv_length_over_width");
  // Volume of the superellipse of revolution: pi R^2 L times the mean of (1 - u^p)^(2/p).
  float mean = 0;
  constexpr int kSteps = 64;
  for (int i = 0; i < kSteps; ++i) {
    const float u = (static_cast<float>(i) + 0.5F) / kSteps;
    mean += std::pow(1 - std::pow(u, exponent_), 2 / exponent_) / kSteps;
  }
  radius_ = std::cbrt(volume / (kPi * mean * 2 * slenderness));
  length_ = 2 * slenderness * radius_;
  const float bend_angle = family.between(0, 2 * kPi, "lv_bend_angle");
  const float bend = family.number("lv_bend");
  bend_x_ = bend * std::cos(bend_angle);
  bend_y_ = bend * std::sin(bend_angle);
  narrowing_ = family.number("lv_base_narrowing");
  lobe2_ = family.number("lv_lobe2");
  lobe2_angle_ = family.between(0, kPi, "lv_lobe2_angle");
  lobe3_ = family.number("lv_lobe3");
  lobe3_angle_ = family.between(0, 2 * kPi, "lv_lobe3_angle");
  flattening_ = family.happens("septum_flat") ? family.number("septal_flattening") : 0;
  bumps_ = family.number("lv_bumps");
  tilt_x_ = 0.12F * family.normal("base_tilt_x");
  tilt_y_ = 0.12F * family.normal("base_tilt_y");
  // Ejection is shared between the base's descent and the radius.
  const float kept = 1 - family.number("lv_ef") / 100;
  mapse_ = length_ * (1 - std::pow(kept, family.number("lv_long_share")));
  radial_loss_ = 1 - std::sqrt(kept / (1 - mapse_ / length_));
  wall_ = std::min(family.number("wall"), 0.9F * radius_);
  uneven1_ = family.number("wall_uneven", 0);
  uneven1_angle_ = family.between(0, 2 * kPi, "wall_uneven_angle", 0);
  uneven2_ = 0.5F * family.number("wall_uneven", 1);
  uneven2_angle_ = family.between(0, kPi, "wall_uneven_angle", 1);
  wall_apex_ = family.number("wall_apex");
  gap_ = family.number("wall_base_gap");
  gap_angle_ = degrees(family.number("wall_gap_angle"));
  gap_sharpness_ = family.number("wall_gap_sharpness");
  lvot_bulge_ = family.number("lvot_bulge");
  lvot_rise_ = family.number("lvot_rise");
  infarct_ = family.happens("infarct");
  scar_angle_ = family.between(0, 2 * kPi, "infarct_angle");
  scar_share_ = family.number("infarct_share");
  scar_width_ = family.number("infarct_width");
  scar_height_ = family.number("infarct_height");
  scar_thin_ = family.number("infarct_thinning");
  scar_still_ = family.number("infarct_bulge");
  smooth_ = family.happens("smooth");
  trabeculae_ = smooth_ ? 0 : std::min(family.number("trabeculae"), 0.35F * radius_);
  trabeculae_density_ = family.number("trabeculae_density");
  const int count = smooth_ ? 0 : static_cast<int>(family.number("papillary_count"));
  for (int i = 0; i < count; ++i) {
    const auto n = static_cast<std::uint32_t>(i);
    const float angle = family.between(0, 2 * kPi, "papillary_angle", n);
    const float off = family.number("papillary_off", n) * radius_;
    const float low = family.number("papillary_low", n) * length_;
    const float high = low + family.number("papillary_long", n) * length_;
    const Vec3F side(std::cos(angle), std::sin(angle), 0);
    papillary_.push_back({off * 0.85F * side + Vec3F(0, 0, low),
                          off * 0.8F * side + Vec3F(0, 0, high),
                          std::min(family.number("papillary_radius", n), 0.3F * radius_)});
  }
}

float DrawnHeart::scar(float share, float cosine, float sine) const {
  if (!infarct_) return 0;
  const float away = 1 - turned(cosine, sine, scar_angle_);
  const float up = (share - scar_share_) / scar_height_;
  const float exponent = away / (scar_width_ * scar_width_) + 0.5F * up * up;
  return exponent > 6 ? 0 : std::exp(-exponent);
}

DrawnHeart::Moment DrawnHeart::moment(float contraction) const {
  Moment out;
  out.contraction = contraction;
  out.base = mapse_ * contraction;
  out.tricuspid = tricuspid_ + tapse_ * contraction;
  out.length = length_ - out.base;
  out.radial = 1 - radial_loss_ * contraction;
  out.wall_gain = length_ / out.length;
  out.rv_depth = 1 - rv_loss_ * contraction;
  out.atria = 1 + filling_ * contraction;
  return out;
}

float DrawnHeart::lvot(const Vec3F& place, const Moment& moment) const {
  if (bare_) return 1e3F;
  const Vec3F at(place.x(), place.y(), place.z() - moment.base);
  const float beyond = (at - lvot_.to).dot((lvot_.to - lvot_.from).normalized());
  return std::max(lvot_.distance(at), beyond);  // The valve is flat.
}

DrawnHeart::Ventricle DrawnHeart::left(const Vec3F& place, const Moment& moment) const {
  Ventricle out;
  const float u = std::max(0.0F, (place.z() - moment.base) / moment.length);
  const float bow = 4 * u * (1 - std::min(u, 1.0F));
  const float x = place.x() - bend_x_ * bow;
  const float y = place.y() - bend_y_ * bow;
  const float r = std::sqrt(x * x + y * y) + 1e-4F;
  const float c = x / r;
  const float s = y / r;
  out.share = u;
  out.cosine = c;
  out.sine = s;
  const float c2 = c * c - s * s;
  const float s2 = 2 * c * s;
  const float c3 = c2 * c - s2 * s;
  const float s3 = s2 * c + c2 * s;
  const float narrow = std::max(0.0F, 1 - 3 * u);
  float shape =
      (1 - narrowing_ * narrow * narrow) *
      (1 + lobe2_ * turned(c2, s2, 2 * lobe2_angle_) + lobe3_ * turned(c3, s3, 3 * lobe3_angle_));
  if (flattening_ > 0 && c > 0) shape *= 1 - flattening_ * c * c * c;
  const float opened = std::max(0.0F, turned(c, s, gap_angle_));
  shape *= 1 + lvot_bulge_ * opened * opened * narrow;
  const float scarred = scar(u, c, s);
  const float still = std::min(1.0F, scarred) * scar_still_;
  const float contracted = 1 - (1 - moment.radial) * (1 - still);
  const float rest_radius = radius_ * shape;
  const float radius = rest_radius * contracted;
  // Level of the superellipse, of first degree along rays from the base's middle.
  const float rho = r / radius;
  const float up = std::pow(u, exponent_);
  const float level = std::pow(up + std::pow(rho, exponent_), 1 / exponent_);
  const float along_r = std::pow(rho / level, exponent_ - 1) / radius;
  const float along_u = u > 0 ? std::pow(u / level, exponent_ - 1) / moment.length : 0;
  out.inner = (level - 1) / std::sqrt(along_r * along_r + along_u * along_u);
  if (bumps_ > 0 && std::abs(out.inner) < 4 * bumps_) {
    out.inner += bumps_ * lattice_noise(Vec3F(x / contracted, y / contracted, u * length_) / 14,
                                        seed_ ^ 0x11U);
  }
  // The wall keeps its volume: (r + w)^2 - r^2 grows as the length shrinks.
  const float taper = 1 - (1 - wall_apex_) * smooth_step((u - 0.3F) / 0.7F);
  const float wall = wall_ * taper *
                     std::max(0.3F, 1 + uneven1_ * turned(c, s, uneven1_angle_) +
                                        uneven2_ * turned(c2, s2, 2 * uneven2_angle_)) *
                     (1 - scar_thin_ * scarred);
  const float girth = std::pow(std::max(0.0F, 1 - up), 1 / exponent_);
  const float before = rest_radius * girth;
  const float now = radius * girth;
  const float area = wall * (2 * before + wall) * moment.wall_gain;
  out.outer = out.inner - (std::sqrt(now * now + area) - now);
  return out;
}

float DrawnHeart::rv_depth(float share, float cosine, float sine) const {
  // Leant over, the arc keeps its ends: the longer side falls off more slowly.
  const float way = std::atan2(sine, cosine);
  const float height = std::max(share, 0.0F) / rv_length_;
  const float narrowed = std::max(0.05F, 1 - rv_narrowing_ * height);
  const float lean = narrowed * rv_lean_;
  const float half = narrowed * rv_half_angle_;
  const float off = way - lean;
  const float angle = std::abs(off) / (off > 0 ? half - lean : half + lean);
  if (angle >= 1 || height >= 1) return -1;
  const float round = std::pow(std::cos(0.5F * kPi * angle), rv_roundness_);
  return rv_depth_ * round * std::pow(1 - std::pow(height, 1.8F), rv_taper_);
}

void DrawnHeart::size_right(const Family& family) {
  rv_half_angle_ = degrees(family.number("rv_half_angle"));
  rv_roundness_ = family.number("rv_roundness");
  rv_length_ = family.number("rv_length");
  rv_lean_ = degrees(family.number("rv_lean"));
  rv_taper_ = family.number("rv_taper");
  rv_narrowing_ = family.number("rv_narrowing");
  tricuspid_ = family.number("tricuspid_beyond_mitral");
  rv_tilt_x_ = tilt_x_ + 0.12F * family.normal("tricuspid_tilt_x");
  rv_tilt_y_ = tilt_y_ + 0.12F * family.normal("tricuspid_tilt_y");
  rv_wall_ = family.number("rv_wall");
  rv_trabeculae_ = smooth_ ? 0 : family.number("rv_trabeculae");
  const float wanted = family.number("rv_over_lv") * family.number("lv_edv") * 1000;
  // The volume grows with the depth: bisection of a coarse sum over angle and height.
  const auto volume = [&](float depth) {
    rv_depth_ = depth;
    float sum = 0;
    constexpr int kHeights = 20;
    constexpr int kAngles = 24;
    const float step = rv_half_angle_ * 2 / kAngles;
    for (int i = 0; i < kHeights; ++i) {
      const float u = (static_cast<float>(i) + 0.5F) / kHeights * rv_length_;
      const float girth = std::pow(std::max(0.0F, 1 - std::pow(u, exponent_)), 1 / exponent_);
      const float outer = radius_ * girth + wall_;
      for (int j = 0; j < kAngles; ++j) {
        const float angle = -rv_half_angle_ + (static_cast<float>(j) + 0.5F) * step;
        const float d = std::max(0.0F, rv_depth(u, std::cos(angle), std::sin(angle)));
        sum += 0.5F * d * (2 * outer + d) * step * length_ * rv_length_ / kHeights;
      }
    }
    return sum;
  };
  float low = 4;
  float high = 75;
  for (int i = 0; i < 16; ++i) {
    const float middle_depth = 0.5F * (low + high);
    (volume(middle_depth) < wanted ? low : high) = middle_depth;
  }
  rv_depth_ = 0.5F * (low + high);
  rv_reach_ = rv_depth_;
  const float kept = 1 - family.number("rv_ef") / 100;
  const float rv_long = length_ * std::min(rv_length_, 1.0F);
  tapse_ = rv_long * (1 - std::pow(kept, family.number("rv_long_share")));
  tapse_ = std::clamp(tapse_, 2.0F, std::min(30.0F, 0.35F * length_));
  const float shortened = tapse_ / rv_long;
  rv_loss_ = std::clamp(1 - kept / (1 - shortened), 0.0F, 0.8F);

  const float angle = -degrees(family.number("outflow_angle"));
  const float radius = std::min(family.number("outflow_radius"), 0.45F * rv_depth_ + 6);
  const float off = radius_ + wall_ + 0.45F * rv_depth_;
  const float rise = family.number("outflow_rise");
  const Vec3F start(off * std::cos(angle), off * std::sin(angle),
                    family.number("outflow_start") * length_);
  const float beyond = angle - degrees(family.number("outflow_turn"));
  const float near = family.number("outflow_near") * (radius_ + wall_);
  const Vec3F valve(near * std::cos(beyond), near * std::sin(beyond), -rise);
  const Vec3F end = valve + Vec3F(-12, -10, -family.number("trunk_long"));
  outflow_ = {Tube{start, valve, radius}, Tube{valve, end, 0.95F * radius}};
}

void DrawnHeart::place_beyond(const Family& family) {
  filling_ = family.number("atrium_filling");
  atrium_wall_ = family.number("atrium_wall");
  mouth_ = std::min(family.number("valve_radius"), 0.8F * radius_);
  const float la = family.number("la_radius");
  const float ra = family.number("ra_radius");
  const auto stretch = [&](std::uint32_t i) { return family.number("atrium_stretch", i); };
  la_.axes = la * Vec3F(stretch(0), stretch(1), 0.9F * stretch(2));
  la_.centre =
      Vec3F(family.number("la_x"), family.number("la_y"), -family.number("la_z") * la_.axes.z());
  ra_.axes = ra * Vec3F(stretch(3), stretch(4), 0.9F * stretch(5));
  const float side = radius_ + wall_ + 0.5F * rv_depth_ + family.number("ra_x");
  ra_.centre = Vec3F(std::max(side, la_.centre.x() + 0.6F * la_.axes.x() + 0.5F * ra_.axes.x()),
                     family.number("ra_y"), tricuspid_ - family.number("ra_z") * ra_.axes.z());
  const float radius = std::min(family.number("aorta_radius"), 0.75F * radius_ + 4);
  const float off = family.number("aorta_off") * radius_;
  const Vec3F root(off * std::cos(gap_angle_), off * std::sin(gap_angle_), 12);
  const float lean = degrees(family.number("lvot_lean"));
  const float turn = gap_angle_ + degrees(family.number("lvot_turn"));
  const Vec3F outflow(std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn),
                      -std::cos(lean));
  const Vec3F valve = root + family.number("lvot_length") * outflow;
  const float reach = family.number("aorta_reach");
  const Vec3F bend = valve + 0.5F * reach * (0.6F * outflow + Vec3F(0, 0, -0.6F)).normalized();
  const Vec3F end = bend + 0.7F * reach * Vec3F(-0.2F, -family.number("aorta_up"), -1);
  lvot_ = Tube{root, valve, radius};
  aorta_ = {Tube{valve, bend, radius}, Tube{bend, end, 0.95F * radius}};
  const int count = static_cast<int>(family.number("vein_count"));
  for (int i = 0; i < count; ++i) {
    const auto n = static_cast<std::uint32_t>(i);
    const bool of_left = i < 3;
    const Ball& from = of_left ? la_ : ra_;
    const Vec3F way(family.normal("vein_x", n), family.normal("vein_y", n),
                    -0.4F - std::abs(family.normal("vein_z", n)));
    const float long_mm = from.axes.maxCoeff() + family.number("vein_long", n);
    veins_.push_back(
        {from.centre, from.centre + long_mm * way.normalized(), family.number("vein_radius", n)});
  }
}

DrawnHeart::Sight DrawnHeart::sight(const Vec3F& place, const Moment& moment) const {
  Sight out;
  out.place = place;
  out.lv = left(place, moment);
  out.tricuspid =
      place.z() - moment.tricuspid - rv_tilt_x_ * (place.x() - radius_) - rv_tilt_y_ * place.y();
  const float toward_gap = std::max(0.0F, turned(out.lv.cosine, out.lv.sine, gap_angle_));
  out.gap = gap_ * std::pow(toward_gap, gap_sharpness_);
  // Toward the aorta the ventricle reaches farther than at the mitral valve.
  const float rise =
      lvot_rise_ * toward_gap * std::min(1.0F, std::hypot(place.x(), place.y()) / radius_);
  out.mitral = place.z() - moment.base - tilt_x_ * place.x() - tilt_y_ * place.y() + rise;
  out.with_tricuspid = {place.x(), place.y(), place.z() - 0.5F * (moment.tricuspid - tricuspid_)};
  out.with_mitral = {place.x(), place.y(), place.z() - 0.5F * moment.base};
  return out;
}

std::optional<Tissue> DrawnHeart::of_left(const Sight& at, const Moment& moment) const {
  const Ventricle& lv = at.lv;
  if (lv.inner < 0) return in_left(at, moment);
  const float tract = lvot(at.place, moment);
  if (tract < 0) return Tissue::LvBlood;
  if (lv.outer < 0) return at.mitral > at.gap && tract > 1.5F ? Tissue::LvMuscle : Tissue::Wall;
  // Beside the ventricles, past all that may lean on them, nothing of the heart is left.
  if (at.tricuspid > 0 && lv.outer > beside_) return Tissue::Outside;
  return std::nullopt;
}

Tissue DrawnHeart::in_left(const Sight& at, const Moment& moment) const {
  const Vec3F& place = at.place;
  if (at.lv.inner > -trabeculae_ && at.lv.share > 0.12F) {
    // Dense at the wall, loose towards the middle; they move together as the cavity shrinks.
    const float grain = 0.5F + 0.9F * lattice_noise(place / 4, seed_ ^ 0x22U);
    if (grain < trabeculae_density_ * (1 + 0.8F * at.lv.inner / trabeculae_) *
                    (1 + 0.4F * moment.contraction)) {
      return Tissue::Papillary;
    }
  }
  const Vec3F rest(place.x() / moment.radial, place.y() / moment.radial,
                   length_ - (length_ - place.z()) * moment.wall_gain);
  for (const Tube& muscle : papillary_) {
    if (muscle.distance(rest) < 0) return Tissue::Papillary;
  }
  return Tissue::LvBlood;
}

float DrawnHeart::from_right(const Sight& at, const Moment& moment) const {
  float out = 1e3F;
  const float depth = at.tricuspid > 0 ? rv_depth(at.lv.share, at.lv.cosine, at.lv.sine) : 0;
  if (depth > 0) {
    out = std::max(at.lv.outer - depth * moment.rv_depth, at.mitral < 0 ? -at.mitral - 6 : -1e3F);
  }
  if (bare_) return out;
  return std::min(out, outflow_[0].distance(at.with_tricuspid) +
                           (1 - moment.rv_depth) * 0.35F * outflow_[0].radius);
}

Tissue DrawnHeart::in_right(const Sight& at, float blood) const {
  if (!smooth_ && (blood > -rv_trabeculae_ || at.lv.outer < 0.4F * rv_trabeculae_)) {
    const float grain = 0.5F + 0.9F * lattice_noise(at.place / 4.5F, seed_ ^ 0x33U);
    if (grain < 0.6F * trabeculae_density_) return Tissue::RvTrabecula;
  }
  return Tissue::RvBlood;
}

bool DrawnHeart::in_vein(const Sight& at) const {
  return std::any_of(veins_.begin(), veins_.end(),
                     [&](const Tube& vein) { return vein.distance(at.with_mitral) < 0; });
}

float DrawnHeart::from_left_atrium(const Sight& at, const Moment& moment) const {
  if (!(at.mitral <= 0) || bare_) return 1e3F;
  const float out = la_.distance(at.with_mitral, moment.atria);
  if (!(at.mitral > -10)) return out;
  return std::min(out, std::hypot(at.place.x(), at.place.y()) - mouth_);
}

float DrawnHeart::from_right_atrium(const Sight& at, const Moment& moment) const {
  if (!(at.tricuspid <= 0 && at.lv.outer > atrium_wall_) || bare_) return 1e3F;
  const float out = ra_.distance(at.with_tricuspid, moment.atria);
  if (!(at.tricuspid > -10)) return out;
  const float off = radius_ + wall_ + 0.5F * rv_depth_ * moment.rv_depth;
  return std::min(out, std::hypot(at.place.x() - off, at.place.y() - 4) - mouth_);
}

Tissue DrawnHeart::around(const Sight& at, float outside) const {
  if (outside < effusion_) return Tissue::Effusion;
  const float beyond = outside - effusion_;
  if (effusion_ > 0 && beyond < pericardium_) return Tissue::Pericardium;
  const float groove = std::exp(-at.mitral * at.mitral / (2 * 10 * 10.0F));
  const float uneven = std::max(0.0F, 1 + 1.2F * lattice_noise(at.place / 30, seed_ ^ 0x44U));
  const float rightward = 0.6F + 0.4F * at.lv.cosine;
  const float depth = fat_ * uneven * rightward + groove_fat_ * groove;
  if (beyond < depth) return Tissue::Fat;
  return beyond < depth + pericardium_ ? Tissue::Pericardium : Tissue::Outside;
}

Tissue DrawnHeart::at(const Vec3F& place, const Moment& moment) const {
  const Sight seen = sight(place, moment);
  const Ventricle& lv = seen.lv;
  const float mitral = seen.mitral;
  if (mitral > 0) {
    if (const auto tissue = of_left(seen, moment)) return *tissue;
  }
  const float rv = from_right(seen, moment);
  const Vec3F with_base(place.x(), place.y(), place.z() - moment.base);
  const float aorta =
      bare_ ? 1e3F : std::min(aorta_[0].distance(with_base), aorta_[1].distance(with_base));
  // The outflow tract is the LV's up to the aortic valve.
  if (mitral <= 0 && lvot(place, moment) < 0) return Tissue::LvBlood;
  if (mitral <= 0 && aorta < 0) return Tissue::Aorta;
  if (rv < 0) return in_right(seen, rv);
  // The outflow tract is the RV's up to its valve, the pulmonary trunk beyond.
  const float trunk = bare_ ? 1e3F : outflow_[1].distance(seen.with_tricuspid);
  if (trunk < 0) return Tissue::Trunk;
  const float la = from_left_atrium(seen, moment);
  if (la < 0) return Tissue::LaBlood;
  const float ra = from_right_atrium(seen, moment);
  if (ra < 0) return Tissue::RaBlood;
  // Fibrous skeleton between the muscle's end and the valves.
  if (mitral <= 0 && mitral > -3 && lv.outer < 0) return Tissue::Wall;
  const float vessel_wall = std::min(aorta, trunk);
  if (rv < rv_wall_ || std::min(la, ra) < atrium_wall_ || (mitral <= 0 && vessel_wall < 1.5F)) {
    return Tissue::Wall;
  }
  if (mitral < 10 && !bare_ && in_vein(seen)) return Tissue::Vessel;
  const float outside =
      std::min({mitral > 0 ? lv.outer : 1e3F, rv - rv_wall_, la - atrium_wall_, ra - atrium_wall_,
                trunk - 1.5F, mitral <= 0 ? aorta - 1.5F : 1e3F});
  return around(seen, outside);
}

}  // namespace beatlas::phantom
