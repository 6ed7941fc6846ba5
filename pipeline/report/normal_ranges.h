#pragma once
/// What is normal, who measured it, and whether it was counted as here.

#include <vector>

#include <nlohmann/json.hpp>

namespace beatlas::report {

/// What the LV's papillary muscles are counted as: it moves volumes and mass by what they hold.
enum class Papillary { None, Blood, Muscle };  ///< None: it is of no LV

/// Limits within which 95 of 100 healthy adults lie, and who measured them.
struct NormalRange {
  const char* figure;  ///< key of the figure, as in report.json
  const char* title;
  const char* unit;
  double men_low;
  double men_high;
  double women_low;
  double women_high;
  int source;  ///< index into normal_sources()
};

struct NormalSource {
  const char* short_name;
  const char* citation;
  const char* how;  ///< what it says of its method
  Papillary papillary;
};

[[nodiscard]] const std::vector<NormalSource>& normal_sources();
[[nodiscard]] const std::vector<NormalRange>& normal_ranges();

/// For the page: {"ranges", "sources"}. A range of the other convention than that of the labels is
/// left out (`men` and `women` are null) and `other` says why: a healthy heart may lie outside it.
[[nodiscard]] nlohmann::json normal_to_json(Papillary labelled);

}  // namespace beatlas::report
