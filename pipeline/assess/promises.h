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
               {{{Structure::Heart, 0.958, 0.81, 0.68, 8.2},
                 {Structure::LvBlood, 0.965, 0.28, 0.21, 3.1},
                 {Structure::RvBlood, 0.917, 0.63, 0.51, 5.9},
                 {Structure::LvMyocardium, 0.948, 0.23, 0.13, 1.4}}},
               0.20},
    PromiseSet{"small",
               "images of the phantom small",
               {{{Structure::Heart, 0.964, 0.81, 0.50, 5.9},
                 {Structure::LvBlood, 0.958, 0.45, 0.32, 3.6},
                 {Structure::RvBlood, 0.905, 0.75, 0.19, 5.0},
                 {Structure::LvMyocardium, 0.948, 0.32, 0.04, 1.8}}},
               0.13},
    PromiseSet{"clinical",
               "images of the phantom clinical",
               {{{Structure::Heart, 0.938},
                 {Structure::LvBlood, 0.938},
                 {Structure::RvBlood, 0.875},
                 {Structure::LvMyocardium, 0.893}}},
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
