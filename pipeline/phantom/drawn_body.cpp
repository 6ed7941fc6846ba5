#include "pipeline/phantom/drawn_body.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace beatlas::phantom {

DrawnBody::DrawnBody(const Family& family, float heart_reach) : seed_(family.seed() ^ 0x5A5AU) {
  width_ = family.number("chest_width");
  depth_ = family.number("chest_depth");
  skin_ = family.number("skin_fat");
  muscle_ = family.number("chest_muscle");
  // The heart leans on the front of the chest, left of its middle.
  const float inner_depth = depth_ - 0.6F * skin_ - muscle_;
  chest_ = {-family.number("chest_x"),
            std::max(0.0F, inner_depth - family.number("chest_y") * heart_reach), 0};
  spine_radius_ = family.number("spine_radius");
  spine_ = {chest_.x(), chest_.y() + inner_depth - spine_radius_, 0};
  descending_ = family.number("descending_radius");
  aorta_ = {spine_.x() + family.number("descending_x"),
            spine_.y() - spine_radius_ - family.number("descending_y"), 0};
  column_ = 15 + family.number("mediastinum");
  fat_pad_ = family.number("fat_pad");
  fat_pad_reach_ = 0.75F * heart_reach;
  diaphragm_ = -heart_reach * family.number("diaphragm");
  liver_to_ = family.number("liver_to");
  stomach_ = {family.number("stomach_x"), family.number("stomach_y"),
              diaphragm_ - family.number("stomach_z")};
  stomach_radius_ = family.number("stomach_radius");
  gas_above_ = family.number("stomach_gas");
  stomach_wall_ = family.number("stomach_wall");
  cortex_ = family.number("kidney_cortex");
  for (std::uint32_t n = 0; n < 2; ++n) {
    const float radius = family.number("kidney_radius", n);
    Kidney& kidney = kidneys_[n];
    kidney.radius = radius;
    kidney.centre = {spine_.x() + (n == 0 ? -1.0F : 1.0F) * family.number("kidney_x", n),
                     spine_.y() - family.number("kidney_y", n),
                     diaphragm_ - family.number("kidney_z", n)};
  }
  loop_ = family.number("bowel_loop");
  loop_wall_ = family.number("bowel_wall");
  arms_ = family.happens("arms");
  const int count = static_cast<int>(family.number("decoys"));
  constexpr std::array<Tissue, 8> kKinds{Tissue::OtherA, Tissue::OtherB,     Tissue::OtherC,
                                         Tissue::OtherD, Tissue::Vessel,     Tissue::Fat,
                                         Tissue::Gas,    Tissue::ChestMuscle};
  for (int i = 0; i < count; ++i) {
    const auto n = static_cast<std::uint32_t>(i);
    Organ organ;
    Vec3F way(family.normal("decoy_x", n), family.normal("decoy_y", n),
              family.normal("decoy_z", n));
    organ.centre = way.normalized() * family.number("decoy_off", n) * heart_reach;
    const float radius = family.number("decoy_radius", n);
    for (std::uint32_t a = 0; a < 3; ++a) {
      const float axis = radius * family.number("decoy_axis", 3 * n + a);
      organ.per_axis[static_cast<Eigen::Index>(a)] = 1 / axis;
    }
    organ.core = kKinds[static_cast<std::size_t>(family.between(0, 7.99F, "decoy_core", n))];
    organ.shell = organ.core;
    if (family.happens("decoy_ring", n)) {
      organ.core = family.uniform("decoy_bright", n) < 0.6F ? Tissue::Vessel : Tissue::OtherA;
      organ.shell = kKinds[static_cast<std::size_t>(family.between(0, 7.99F, "decoy_shell", n))];
      organ.shell_from = family.number("decoy_from", n);
    }
    organs_.push_back(organ);
  }
  for (std::uint32_t n = 0; n < 4; ++n) {
    if (!family.happens("heart_like", n)) continue;
    Organ organ;
    // Mostly below the heart.
    const Vec3F way(family.normal("heart_like_x", n), family.normal("heart_like_y", n),
                    family.normal("heart_like_z", n) - 1);
    organ.centre = way.normalized() * family.number("heart_like_off", n) * heart_reach;
    const float radius = family.number("heart_like_radius", n);
    const float outer = radius + family.number("heart_like_wall", n);
    organ.per_axis = Vec3F(1, 1, 0.7F) / outer;
    organ.core = Tissue::Vessel;
    organ.shell =
        family.uniform("heart_like_shell", n) < 0.7F ? Tissue::ChestMuscle : Tissue::OtherA;
    organ.shell_from = radius / outer;
    organs_.insert(organs_.begin(), organ);
  }
}

Tissue DrawnBody::abdomen(const Vec3F& lps, float rough) const {
  const float stomach = (lps - stomach_).norm() - stomach_radius_ * (1 + 0.2F * rough);
  if (stomach < -stomach_wall_ * (1 + 0.5F * rough)) {
    return lps.y() < stomach_.y() - gas_above_ * 0.3F ? Tissue::Gas : Tissue::Stomach;
  }
  if (stomach < 0) return Tissue::ChestMuscle;
  for (const Kidney& kidney : kidneys_) {
    const Vec3F off = (lps - kidney.centre).cwiseProduct(Vec3F(1, 1, 0.55F));
    const float inside = kidney.radius * (1 + 0.1F * rough) - off.norm();
    if (inside <= 0) continue;
    if (inside < cortex_) return Tissue::OtherA;
    return off.norm() < 0.35F * kidney.radius ? Tissue::Vessel : Tissue::OtherB;
  }
  if (lps.x() < liver_to_ + 15 * rough) {
    return lattice_noise(lps / 13, seed_ ^ 0x72U) > 0.72F ? Tissue::Vessel : Tissue::Liver;
  }
  if (lps.y() > 30) return Tissue::Spleen;
  // Loops of bowel: cells about points that stand one in each cube, what lies between is wall.
  const Vec3F in_loops = lps / loop_;
  const Vec3F corner = (in_loops.array() - 0.5F).floor();
  float nearest = 1e3F;
  float next = 1e3F;
  float kind = 0;
  for (int n = 0; n < 8; ++n) {
    const Vec3F cube = corner + Vec3F(static_cast<float>(n & 1), static_cast<float>((n >> 1) & 1),
                                      static_cast<float>(n >> 2));
    const Vec3F off(lattice_value(cube, seed_ ^ 0x81U), lattice_value(cube, seed_ ^ 0x82U),
                    lattice_value(cube, seed_ ^ 0x83U));
    const Vec3F point = cube + Vec3F::Constant(0.5F) + 0.35F * off;
    const float far = (in_loops - point).norm();
    if (far < nearest) {
      next = nearest;
      nearest = far;
      kind = lattice_value(cube, seed_ ^ 0x84U);
    } else {
      next = std::min(next, far);
    }
  }
  const float wall = (next - nearest) * loop_;
  if (wall < 2 * loop_wall_) return wall < loop_wall_ ? Tissue::Fat : Tissue::ChestMuscle;
  constexpr std::array<Tissue, 6> kContents{Tissue::OtherC,  Tissue::OtherD, Tissue::Gas,
                                            Tissue::Stomach, Tissue::Fat,    Tissue::OtherB};
  return kContents[static_cast<std::size_t>(std::clamp((kind + 1) * 3, 0.0F, 5.99F))];
}

Tissue DrawnBody::beyond_chest(float past_side, float y) const {
  if (arms_) {
    const float arm = std::hypot(past_side * width_ - width_ - 45, y - 20);
    if (arm < 38) return arm < 12 ? Tissue::Bone : arm < 30 ? Tissue::ChestMuscle : Tissue::Fat;
  }
  return Tissue::Outside;
}

Tissue DrawnBody::in_chest_wall(const Vec3F& lps, float rough) const {
  if (rough > 0.35F) return Tissue::Bone;
  return lattice_noise(lps / 9, seed_ ^ 0x71U) > 0.4F ? Tissue::Fat : Tissue::ChestMuscle;
}

std::optional<Tissue> DrawnBody::in_organ(const Vec3F& lps, float rough) const {
  for (const Organ& organ : organs_) {
    const float radius = (lps - organ.centre).cwiseProduct(organ.per_axis).norm();
    if (radius < 1 + 0.2F * rough) return radius > organ.shell_from ? organ.shell : organ.core;
  }
  return std::nullopt;
}

Tissue DrawnBody::among_lungs(const Vec3F& lps, float x, float rough) const {
  if (std::abs(x) < column_ + 12 * rough) {
    const float grain = lattice_noise(lps / 11, seed_ ^ 0x73U);
    return grain > 0.5F ? Tissue::Vessel : grain > -0.1F ? Tissue::Fat : Tissue::Mediastinum;
  }
  const float near = 1 - lps.norm() / fat_pad_reach_;
  if (lattice_noise(lps / 28, seed_ ^ 0x75U) + 1 < 4 * fat_pad_ * near) return Tissue::Fat;
  return lattice_noise(lps / 7, seed_ ^ 0x74U) > 0.7F ? Tissue::Vessel : Tissue::Lung;
}

Tissue DrawnBody::at(const Vec3F& lps) const {
  const float x = lps.x() - chest_.x();
  const float y = lps.y() - chest_.y();
  const float z = lps.z();
  // A rounded box serves a chest better than an ellipse does.
  const float ax = std::abs(x / width_);
  const float ay = std::abs(y / depth_);
  const float level = std::sqrt(std::sqrt(ax * ax * ax * ax + ay * ay * ay * ay) * 0.5F +
                                0.5F * (ax * ax + ay * ay));
  if (level >= 1) return beyond_chest(ax, y);
  const float rough = lattice_noise(lps / 22, seed_);
  const float in = (1 - level) * std::min(width_, depth_);
  const float side = ax > ay ? 1.0F : 0.6F;  // Less fat in front and behind.
  if (in < skin_ * side) return Tissue::Fat;
  if (in < skin_ * side + muscle_ * (0.9F + 0.2F * rough)) return in_chest_wall(lps, rough);
  if (const auto organ = in_organ(lps, rough)) return *organ;
  const float spine = std::hypot(lps.x() - spine_.x(), lps.y() - spine_.y());
  if (spine < spine_radius_) {
    return std::fmod(std::abs(z), 32.0F) < 7 ? Tissue::OtherD : Tissue::Bone;
  }
  if (std::hypot(lps.x() - aorta_.x(), lps.y() - aorta_.y()) < descending_) return Tissue::Vessel;
  const float dome = diaphragm_ + 6 * rough - 0.0012F * (x * x + 1.5F * y * y);
  return z < dome ? abdomen(lps, rough) : among_lungs(lps, x, rough);
}

}  // namespace beatlas::phantom
