#pragma once
/// The knobs of `beatlas bench`, as data, and the runs they ask for. A new knob is an entry of one
/// of the lists that bench_knobs() joins.

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace beatlas::assess {

/// What the package is made from.
enum class Sweep {
  Images,  ///< end to end: rendered, segmented, registered
  Exact,  ///< the field stage is given the closed form's level: no error but its own and later ones
};

/// What is packed and asked.
enum class Family {
  Field,      ///< the scene palpation: the heart's field; ventricles from a second package
  Surface,    ///< the scene anatomy: surfaces
  Volume,     ///< the images around the heart, as the scene full has them
  Published,  ///< paper A: the digitised labels, no package
};

/// One option, by its place in the settings, and what it is set to.
struct KnobAxis {
  std::string pointer;  ///< JSON pointer: /field/voxel_mm as in a recipe, /query/space, /level/...
  std::vector<nlohmann::json> values;
  std::vector<nlohmann::json> quick;  ///< with --quick
};

/// Options that are varied together, every value of one with every value of the others.
struct Knob {
  std::string name;   ///< as --only names it
  std::string title;  ///< in tables and plots
  Sweep sweep{};
  Family family{};
  std::vector<KnobAxis> axes;
  /// Of Field: the ventricles' fields are built and measured too, else the heart's alone.
  bool ventricles = true;
};

[[nodiscard]] const std::vector<Knob>& bench_knobs();
/// Each name once, in order.
[[nodiscard]] std::vector<std::string> bench_knob_names();

/// One setting to be measured.
struct BenchRun {
  std::string knob;
  std::string title;
  Sweep sweep{};
  Family family{};
  nlohmann::json values;    ///< {pointer: value} of the knob's axes
  nlohmann::json settings;  ///< the whole settings
  bool is_default = false;  ///< all values are the defaults
  bool ventricles = true;   ///< as the knob's; the default run always measures them
};

/// @param defaults a recipe with all options, and the sections "phantom", "level" and "query"
/// @param only names of knobs; empty = all
/// @throws Error{Usage} for a name that is no knob's, listing those that are.
[[nodiscard]] std::vector<BenchRun> plan_runs(const std::vector<Knob>& knobs,
                                              const std::vector<std::string>& only,
                                              const nlohmann::json& defaults, bool quick);

/// The first stage that the two settings make differ, of "phantom", "segment", "register", "field",
/// "mesh", "level", "pack", "query"; "" if none does.
[[nodiscard]] std::string first_difference(const nlohmann::json& one, const nlohmann::json& other);

/// "images" and "exact"; "field", "surface", "volume" and "published".
[[nodiscard]] std::string_view sweep_name(Sweep sweep);
[[nodiscard]] std::string_view family_name(Family family);

}  // namespace beatlas::assess
