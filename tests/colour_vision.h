#pragma once
/// How different two colours of sRGB look, also to eyes that lack one kind of cones.

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "runtime/base/geometry.h"

namespace beatlas::test {

/// The eyes of most people, and those without the cones for red, green or blue.
enum class Eyes : std::uint8_t { Usual, Protanope, Deuteranope, Tritanope };
inline constexpr std::array kAllEyes{Eyes::Usual, Eyes::Protanope, Eyes::Deuteranope,
                                     Eyes::Tritanope};

/// Linear light, 0..1, of a colour of 8 bits each.
inline Vec3 linear_of(const std::array<std::uint8_t, 3>& colour) {
  return Vec3(colour[0], colour[1], colour[2]).unaryExpr([](double c) {
    const double s = c / 255;
    return s > 0.04045 ? std::pow((s + 0.055) / 1.055, 2.4) : s / 12.92;
  });
}

/// What such eyes make of it: Machado, Oliveira and Fernandes 2009, severity 1.
inline Vec3 seen_by(Eyes eyes, const Vec3& linear) {
  Eigen::Matrix3d seen = Eigen::Matrix3d::Identity();
  if (eyes == Eyes::Protanope) {
    seen << 0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116,
        1.051998;
  } else if (eyes == Eyes::Deuteranope) {
    seen << 0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940,
        0.968881;
  } else if (eyes == Eyes::Tritanope) {
    seen << 1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367,
        0.303900;
  }
  return (seen * linear).cwiseMax(0.0).cwiseMin(1.0);
}

/// CIE L*a*b* of linear sRGB, D65.
inline Vec3 lab_of(const Vec3& linear) {
  Eigen::Matrix3d xyz_from_rgb;
  xyz_from_rgb << 0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339,
      0.1191920, 0.9503041;
  const Vec3 white = xyz_from_rgb * Vec3::Ones();
  const Vec3 f = (xyz_from_rgb * linear).cwiseQuotient(white).unaryExpr([](double t) {
    return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
  });
  return {116 * f.y() - 16, 500 * (f.x() - f.y()), 200 * (f.y() - f.z())};
}

/// Difference of two colours of L*a*b* by CIEDE2000 (Sharma, Wu and Dalal 2005): 1 is just seen
/// side by side, 10 at a glance.
inline double ciede2000(const Vec3& one, const Vec3& other) {
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const auto seventh = [](double c) {
    return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25.0, 7)));
  };
  const auto chroma = [](const Vec3& lab) { return std::hypot(lab.y(), lab.z()); };
  const double stretch = 1.5 - 0.5 * seventh(0.5 * (chroma(one) + chroma(other)));
  const auto stretched = [&](Vec3 lab) {
    lab.y() *= stretch;
    return lab;
  };
  const Vec3 a = stretched(one);
  const Vec3 b = stretched(other);
  const double chroma_a = chroma(a);
  const double chroma_b = chroma(b);
  const auto hue = [](const Vec3& lab) {
    const double degrees = std::atan2(lab.z(), lab.y()) * 180 / std::numbers::pi;
    return degrees < 0 ? degrees + 360 : degrees;
  };
  const bool hueless = chroma_a * chroma_b == 0;
  const double hue_a = hue(a);
  const double hue_b = hue(b);
  double turn = hueless ? 0 : hue_b - hue_a;
  if (turn > 180) turn -= 360;
  if (turn < -180) turn += 360;
  double middle = hue_a + hue_b;
  if (!hueless) {
    const bool apart = std::abs(hue_a - hue_b) > 180;
    middle = 0.5 * (apart ? middle + (middle < 360 ? 360 : -360) : middle);
  }
  const double light = 0.5 * (a.x() + b.x());
  const double strong = 0.5 * (chroma_a + chroma_b);
  const double t = 1 - 0.17 * std::cos(radians(middle - 30)) +
                   0.24 * std::cos(radians(2 * middle)) + 0.32 * std::cos(radians(3 * middle + 6)) -
                   0.20 * std::cos(radians(4 * middle - 63));
  const double off = (light - 50) * (light - 50);
  const double d_light = (b.x() - a.x()) / (1 + 0.015 * off / std::sqrt(20 + off));
  const double d_chroma = (chroma_b - chroma_a) / (1 + 0.045 * strong);
  const double d_hue =
      2 * std::sqrt(chroma_a * chroma_b) * std::sin(radians(turn / 2)) / (1 + 0.015 * strong * t);
  const double rotation =
      -2 * seventh(strong) * std::sin(radians(60 * std::exp(-std::pow((middle - 275) / 25, 2))));
  return std::sqrt(d_light * d_light + d_chroma * d_chroma + d_hue * d_hue +
                   rotation * d_chroma * d_hue);
}

/// The same as such eyes see them.
inline double difference(const std::array<std::uint8_t, 3>& one,
                         const std::array<std::uint8_t, 3>& other, Eyes eyes) {
  return ciede2000(lab_of(seen_by(eyes, linear_of(one))), lab_of(seen_by(eyes, linear_of(other))));
}

/// Of WCAG 2: 1 to 21; words want 4.5, lines and surfaces 3.
inline double contrast(const std::array<std::uint8_t, 3>& one,
                       const std::array<std::uint8_t, 3>& other) {
  const auto luminance = [](const std::array<std::uint8_t, 3>& colour) {
    return Vec3(0.2126, 0.7152, 0.0722).dot(linear_of(colour)) + 0.05;
  };
  const double a = luminance(one);
  const double b = luminance(other);
  return std::max(a, b) / std::min(a, b);
}

}  // namespace beatlas::test
