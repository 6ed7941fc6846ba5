#pragma once
/// What is promised of phantoms (docs/promises.md, which tells where it comes from), and what a
/// package is held to because of it: 1.3 times the promised error. The margin is for other noise,
/// another view and another compiler, and small enough that a change for the worse is noticed.

#include <array>
#include <optional>
#include <string_view>

#include "runtime/atlas/structures.h"

namespace beatlas::assess {

inline constexpr double kPromiseMargin = 1.3;

/// Of one structure over the whole beat; what is not promised is not there.
struct Promised {
  Structure structure{};
  std::optional<double> least_dice = {};  ///< of the phases
  std::optional<double> mean_mm = {};     ///< distance of the surfaces, mean over the phases
  std::optional<double> bias_mm = {};     ///< magnitude of the signed mean over the phases
  std::optional<double> p95_mm = {};      ///< of the worst phase
};

/// What is promised of packages that were made in one way.
struct PromiseSet {
  std::string_view name;       ///< of `beatlas validate --limits`
  std::string_view made_from;  ///< the same in words
  std::array<Promised, 4> structures;
  std::optional<double> force_mean_n = {};  ///< felt at the heart in the standard palpations
};

/// Of phantoms from their images, by the name of the phantom, and from labels of the truth, where
/// little is left to err.
inline constexpr std::array kPromiseSets{
    PromiseSet{"adult",
               "images of the phantom adult",
               {{{Structure::Heart, 0.974, 0.53, 0.33, 6.5},
                 {Structure::LvBlood, 0.976, 0.20, 0.12, 2.4},
                 {Structure::RvBlood, 0.926, 0.33, 0.12, 3.7},
                 {Structure::LvMyocardium, 0.964, 0.17, 0.06, 1.1}}},
               0.13},
    PromiseSet{"small",
               "images of the phantom small",
               {{{Structure::Heart, 0.971, 0.63, 0.15, 5.7},
                 {Structure::LvBlood, 0.968, 0.36, 0.26, 3.2},
                 {Structure::RvBlood, 0.949, 0.48, 0.19, 2.8},
                 {Structure::LvMyocardium, 0.960, 0.26, 0.04, 1.3}}},
               0.13},
    PromiseSet{"clinical",
               "images of the phantom clinical",
               {{{Structure::Heart, 0.958},
                 {Structure::LvBlood, 0.985},
                 {Structure::RvBlood, 0.902},
                 {Structure::LvMyocardium, 0.917}}},
               {}},
    PromiseSet{"labels",
               "labels of the truth",
               {{{Structure::Heart, {}, 0.07},
                 {Structure::LvBlood, {}, 0.07},
                 {Structure::RvBlood, {}, 0.07},
                 {Structure::LvMyocardium, {}, 0.07}}}},
    PromiseSet{"coverage",
               "labels of the truth and their coverage",
               {{{Structure::Heart, {}, 0.03, 0.03},
                 {Structure::LvBlood, {}, 0.03, 0.03},
                 {Structure::RvBlood, {}, 0.03, 0.03},
                 {Structure::LvMyocardium, {}, 0.03, 0.03}}}},
};

/// Null for a name that no set has.
[[nodiscard]] const PromiseSet* promise_set(std::string_view name) noexcept;

/// What an error may be of which `promised` is promised.
[[nodiscard]] constexpr double most_error(double promised) noexcept {
  return kPromiseMargin * promised;
}
/// What a Dice may be: its way from 1 is the error.
[[nodiscard]] constexpr double least_dice(double promised) noexcept {
  return 1 - kPromiseMargin * (1 - promised);
}

}  // namespace beatlas::assess
