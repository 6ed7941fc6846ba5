#include "pipeline/cli/seeds.h"

#include "pipeline/study/files.h"
#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::cli {
using nlohmann::json;
namespace {

constexpr double kFarthestMm = 5000;  // beyond any scanner's bore

segment::Seed seed_from_json(const json& value, const std::string& path) {
  JsonObject object(value, path);
  segment::Seed seed;
  int label = 0;
  (void)object.at("label");
  object.read("label", label, kLabelBackground, kLabelRestOfHeart);
  seed.label = static_cast<std::uint8_t>(label);
  const std::vector<double> place = study::numbers_from_json(object.at("lps_mm"), path + "/lps_mm");
  if (place.size() != 3) throw_invalid(path + "/lps_mm must be 3 numbers");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(place[axis] >= -kFarthestMm && place[axis] <= kFarthestMm)) {
      throw_invalid(path + "/lps_mm must lie within -5000 to 5000 mm");
    }
    seed.lps_mm[static_cast<Eigen::Index>(axis)] = place[axis];
  }
  object.read("radius_mm", seed.radius_mm, 0.1, 50);
  object.read("phase", seed.phase, -1, 1023);
  object.finish();
  return seed;
}

}  // namespace

std::vector<segment::Seed> seeds_from_json(const json& value) {
  JsonObject object(value, "");
  const json& list = object.at("seeds");
  if (!list.is_array() || list.empty()) throw_invalid("/seeds must be a list of one seed or more");
  std::vector<segment::Seed> seeds;
  for (std::size_t at = 0; at < list.size(); ++at) {
    seeds.push_back(seed_from_json(list[at], "/seeds/" + std::to_string(at)));
  }
  object.finish();
  return seeds;
}

json seeds_to_json(const std::vector<segment::Seed>& seeds) {
  json list = json::array();
  for (const segment::Seed& seed : seeds) {
    list.push_back({{"label", seed.label},
                    {"lps_mm", {seed.lps_mm[0], seed.lps_mm[1], seed.lps_mm[2]}},
                    {"radius_mm", seed.radius_mm},
                    {"phase", seed.phase}});
  }
  return {{"seeds", list}};
}

std::vector<segment::Seed> read_seeds(const std::filesystem::path& file) {
  const json content = study::read_json(file);
  try {
    return seeds_from_json(content);
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

}  // namespace beatlas::cli
