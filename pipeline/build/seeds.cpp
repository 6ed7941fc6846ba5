#include "pipeline/build/seeds.h"

#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::build {
using nlohmann::json;
namespace {

constexpr std::size_t kMostPlaces = 10000;
constexpr int kVersion = 1;

Vec3 place_from_json(const json& value, const std::string& path) {
  const std::vector<double> place = study::numbers_from_json(value, path);
  if (place.size() != 3) throw_invalid(path + " must be 3 numbers");
  for (const double number : place) {
    if (!(number >= -kFarthestMm && number <= kFarthestMm)) {
      throw_invalid(path + " must lie within -5000 to 5000 mm");
    }
  }
  return {place[0], place[1], place[2]};
}

void read_stroke(const json& list, const std::string& path, segment::Seed& seed) {
  if (!list.is_array() || list.size() < 2 || list.size() > kMostPlaces) {
    throw_invalid(path + " must be a list of 2 to " + std::to_string(kMostPlaces) + " places");
  }
  for (std::size_t at = 0; at < list.size(); ++at) {
    const Vec3 place = place_from_json(list[at], path + "/" + std::to_string(at));
    if (at == 0) {
      seed.lps_mm = place;
    } else {
      seed.stroke_lps_mm.push_back(place);
    }
  }
}

segment::Seed seed_from_json(const json& value, const std::string& path) {
  JsonObject object(value, path);
  segment::Seed seed;
  int label = 0;
  (void)object.at("label");
  object.read("label", label, kLabelBackground, kLabelRestOfHeart);
  seed.label = static_cast<std::uint8_t>(label);
  if (object.has("lps_mm") == object.has("stroke_lps_mm")) {
    throw_invalid(path + " must have either lps_mm, for a ball, or stroke_lps_mm");
  }
  if (object.has("lps_mm")) {
    seed.lps_mm = place_from_json(object.at("lps_mm"), path + "/lps_mm");
  } else {
    read_stroke(object.at("stroke_lps_mm"), path + "/stroke_lps_mm", seed);
  }
  object.read("radius_mm", seed.radius_mm, 0.1, 50);
  object.read("phase", seed.phase, -1, study::kLastPhase);
  object.finish();
  return seed;
}

}  // namespace

std::vector<segment::Seed> seeds_from_json(const json& value) {
  JsonObject object(value, "");
  int version = kVersion;
  object.read("version", version, 0, 1 << 30);
  if (version != kVersion) {
    throw_invalid("/version is " + std::to_string(version) +
                  ", this program reads seeds of version " + std::to_string(kVersion));
  }
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
  const auto numbers = [](const Vec3& place) { return json{place[0], place[1], place[2]}; };
  json list = json::array();
  for (const segment::Seed& seed : seeds) {
    json entry{{"label", seed.label}, {"radius_mm", seed.radius_mm}, {"phase", seed.phase}};
    if (seed.stroke_lps_mm.empty()) {
      entry["lps_mm"] = numbers(seed.lps_mm);
    } else {
      json& stroke = entry["stroke_lps_mm"] = json::array({numbers(seed.lps_mm)});
      for (const Vec3& place : seed.stroke_lps_mm) stroke.push_back(numbers(place));
    }
    list.push_back(std::move(entry));
  }
  return {{"version", kVersion}, {"seeds", list}};
}

}  // namespace beatlas::build
