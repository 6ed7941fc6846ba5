#include "pipeline/phantom/family.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include <nlohmann/json.hpp>

#include "pipeline/phantom/noise.h"

namespace beatlas::phantom {

extern const char* const kFamilyText;  ///< family.json

namespace {

struct Range {
  float low = 0;
  float high = 0;
  bool log = false;
  float chance = 0;
};

struct Row {
  Range whole;
  Range usual;
};

Range range_in(const nlohmann::json& row, const Range& otherwise) {
  return {row.value("low", otherwise.low), row.value("high", otherwise.high), otherwise.log,
          row.value("chance", otherwise.chance)};
}

const Range& range_of(std::string_view name, Ranges ranges) {
  static const std::unordered_map<std::string, Row> table = [] {
    std::unordered_map<std::string, Row> out;
    const nlohmann::json rows = nlohmann::json::parse(kFamilyText);
    for (const auto& [key, row] : rows.items()) {
      const bool log = row.value("law", std::string()) == "log";
      const Range whole = range_in(row, {0, 0, log, 0});
      out[key] = {whole, row.contains("usual") ? range_in(row["usual"], whole) : whole};
    }
    return out;
  }();
  const auto at = table.find(std::string(name));
  if (at == table.end()) {
    throw std::logic_error("family.json has no row \"" + std::string(name) + "\"");
  }
  return ranges == Ranges::Usual ? at->second.usual : at->second.whole;
}

/// FNV-1a (Fowler, Noll, Vo).
std::uint32_t hash_of(std::string_view name) {
  std::uint32_t hash = 2166136261U;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

float open_unit(std::uint32_t bits) {
  return static_cast<float>((static_cast<double>(bits) + 0.5) / 4294967296.0);
}

}  // namespace

std::uint32_t Family::bits(std::string_view name, std::uint32_t index, int which) const {
  constexpr std::uint32_t kFamilyKey = 0x48454152U;  // Apart from the phantom's own draws.
  return philox({index, hash_of(name), static_cast<std::uint32_t>(purpose_), 0},
                {seed_, kFamilyKey})[static_cast<std::size_t>(which)];
}

float Family::uniform(std::string_view name, std::uint32_t index) const {
  return open_unit(bits(name, index, 0));
}

float Family::normal(std::string_view name, std::uint32_t index) const {
  // Box-Muller.
  return std::sqrt(-2.0F * std::log(open_unit(bits(name, index, 1)))) *
         std::cos(2.0F * std::numbers::pi_v<float> * open_unit(bits(name, index, 2)));
}

float Family::number(std::string_view name, std::uint32_t index) const {
  const Range& range = range_of(name, ranges_);
  const float u = uniform(name, index);
  return range.log ? range.low * std::pow(range.high / range.low, u)
                   : range.low + (range.high - range.low) * u;
}

bool Family::in_range(std::string_view name, float value) {
  const Range& range = range_of(name, Ranges::Whole);
  return range.low <= value && value <= range.high;
}

bool Family::happens(std::string_view name, std::uint32_t index) const {
  return uniform(name, index) < range_of(name, ranges_).chance;
}

}  // namespace beatlas::phantom
