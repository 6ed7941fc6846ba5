#include "pipeline/prior/model.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "pipeline/core/words.h"
#include "pipeline/prior/graph_ends.h"
#include "pipeline/prior/network.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"
#include "runtime/base/json_text.h"
#include "runtime/base/sha256.h"

namespace beatlas::prior {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr std::array<std::string_view, 5> kChannelWords{"frame", "below", "above", "mean",
                                                        "deviation"};
constexpr std::array kNeeded{kLabelBackground, kLabelRvBlood, kLabelLvMyocardium, kLabelLvBlood};
constexpr float kLeastTone = 0.2F;
constexpr float kMostTone = 2;
constexpr std::size_t kMostTones = 8;
constexpr std::uintmax_t kMostBytes = 2'147'483'647;  // no ONNX file in one piece is larger

[[nodiscard]] std::vector<std::byte> bytes_of(const fs::path& file) {
  std::error_code failed;
  if (!fs::is_regular_file(file, failed)) {
    throw_invalid("there is no such file; a model is NAME.onnx with NAME.json beside it");
  }
  const std::uintmax_t size = fs::file_size(file, failed);
  if (failed || size > kMostBytes) throw_invalid("it is larger than 2 GB, as no model is");
  std::vector<std::byte> out(size);
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(size));
  if (!in) throw_invalid("it cannot be read; check its permissions");
  return out;
}

/// Places in `words` of a list of some of them, each once.
template <std::size_t N>
std::vector<std::size_t> words_at(JsonObject& object, const std::string& key,
                                  const std::array<std::string_view, N>& words) {
  const json& list = object.at(key);
  const std::string path = object.path() + "/" + key;
  std::string known;
  for (const std::string_view word : words) {
    known.append(known.empty() ? "" : ", ").append(word);
  }
  if (!list.is_array() || list.empty()) throw_invalid(path + " must be a list of some of " + known);
  std::vector<std::size_t> out;
  for (std::size_t at = 0; at < list.size(); ++at) {
    const std::string place = path + "/" + std::to_string(at);
    const auto* word = list[at].get_ptr<const std::string*>();
    const auto found = word == nullptr ? words.end() : std::find(words.begin(), words.end(), *word);
    if (found == words.end()) {
      throw_invalid(std::string(place).append(" must be one of ").append(known));
    }
    const auto index = static_cast<std::size_t>(found - words.begin());
    if (std::find(out.begin(), out.end(), index) != out.end()) {
      throw_invalid(std::string(place).append(" stands there twice"));
    }
    out.push_back(index);
  }
  return out;
}

template <class T>
void read_needed(JsonObject& object, const std::string& key, T& value, T low, T high) {
  (void)object.at(key);
  object.read(key, value, low, high);
}

void check_card(const json& card) {
  if (!card.is_object()) throw_invalid("/card must be a JSON object");
  for (const auto& item : card.items()) {
    if (!item.value().is_string() && !item.value().is_number()) {
      throw_invalid("/card/" + item.key() + " must be a string or a number");
    }
  }
}

void read_tones(const json& value, std::vector<float>& tones) {
  const auto fits = [](const json& tone) {
    return tone.is_number() && kLeastTone <= tone.get<float>() && tone.get<float>() <= kMostTone;
  };
  if (!value.is_array() || value.empty() || value.size() > kMostTones ||
      !std::all_of(value.begin(), value.end(), fits)) {
    throw_invalid("/tones must be a list of up to 8 numbers from 0.2 to 2");
  }
  tones = value.get<std::vector<float>>();
}

void read_lv_ml(const json& value, std::array<double, 2>& lv_ml) {
  constexpr double kMostMl = 1000;
  const bool two =
      value.is_array() && value.size() == 2 && value[0].is_number() && value[1].is_number();
  if (two) lv_ml = {value[0].get<double>(), value[1].get<double>()};
  if (!two || !(0 <= lv_ml[0] && lv_ml[0] <= lv_ml[1] && lv_ml[1] <= kMostMl)) {
    throw_invalid("/lv_ml must be two ascending numbers of ml from 0 to 1000");
  }
}

/// What the graph says of the planes of its only input or output.
void check_planes(const std::vector<std::vector<long long>>& ends, std::size_t planes,
                  const std::string& what, const std::string& word) {
  if (ends.size() != 1) {
    throw_invalid("the network has " + counted(ends.size(), what) + " where it must have one");
  }
  const std::vector<long long>& sizes = ends.front();
  if (sizes.empty()) return;  // it does not say
  if (sizes.size() != 4) {
    throw_invalid("the network's " + what + " has " + counted(sizes.size(), "axis") +
                  " where it must have four, N x planes x H x W");
  }
  if (sizes[1] != 0 && sizes[1] != static_cast<long long>(planes)) {
    throw_invalid("the network's " + what + " has " + counted(sizes[1], "plane") +
                  ", and its JSON names " + counted(planes, word) +
                  "; mend the list or export the "
                  "network again");
  }
}

}  // namespace

ModelCard model_card_from_json(const json& value) {
  JsonObject object(value, "");
  int format = 0;
  read_needed(object, "format", format, 0, 1'000'000);
  if (format != 1) {
    throw_invalid("/format is " + std::to_string(format) +
                  ", and this program knows 1; use a model of that format or a newer beatlas");
  }
  ModelCard out;
  read_needed(object, "pixel_mm", out.pixel_mm, 0.5, 10.0);
  read_needed(object, "neighbour_mm", out.neighbour_mm, 4.0, 20.0);
  read_needed(object, "multiple", out.multiple, 1, 256);
  object.read("orientations", out.orientations, 1, 8);
  if (object.has("lv_ml")) read_lv_ml(object.at("lv_ml"), out.lv_ml);
  if (object.has("tones")) read_tones(object.at("tones"), out.tones);
  for (const std::size_t at : words_at(object, "channels", kChannelWords)) {
    out.channels.push_back(static_cast<Channel>(at));
  }
  for (const std::size_t at : words_at(object, "outputs", kLabelWords)) {
    out.outputs.push_back(static_cast<std::uint8_t>(at));
  }
  for (const std::uint8_t label : kNeeded) {
    if (std::find(out.outputs.begin(), out.outputs.end(), label) == out.outputs.end()) {
      throw_invalid("/outputs lacks " + std::string(kLabelWords.at(label)) +
                    ", without which no heart can be told");
    }
  }
  (void)object.at("sha256");
  object.read("sha256", out.sha256);
  if (out.sha256.size() != 64 ||
      out.sha256.find_first_not_of("0123456789abcdef") != std::string::npos) {
    throw_invalid("/sha256 must be 64 digits 0-9 a-f");
  }
  if (object.has("card")) {
    out.card = object.at("card");
    check_card(out.card);
  }
  object.finish();
  return out;
}

fs::path card_path(const fs::path& onnx) { return fs::path(onnx).replace_extension(".json"); }

Model Model::load(const fs::path& onnx) {
  Model out;
  const fs::path json_file = card_path(onnx);
  try {
    if (json_file == onnx) {
      throw_invalid("it is the description of a model; name the .onnx file beside it");
    }
    out.onnx_ = std::make_shared<const std::vector<std::byte>>(bytes_of(onnx));
    const GraphEnds ends = graph_ends(*out.onnx_);
    try {
      const std::vector<std::byte> text = bytes_of(json_file);
      const json content = parse_json({reinterpret_cast<const char*>(text.data()), text.size()});
      if (content.is_discarded()) throw_invalid("it is no JSON, or cut");
      out.card_ = model_card_from_json(content);
    } catch (const Error& error) {
      throw error.with_context("its description " + json_file.filename().string());
    }
    if (sha256_hex(*out.onnx_) != out.card_.sha256) {
      throw_invalid("its SHA-256 is not that of " + json_file.filename().string() +
                    ": it is cut, or the two do not belong together; copy both again");
    }
    check_planes(ends.inputs, out.card_.channels.size(), "input", "channel");
    check_planes(ends.outputs, out.card_.outputs.size(), "output", "output");
    with_quiet_opencv([&] {
      const int side = out.card_.multiple;
      const std::vector<float> zeros(out.card_.channels.size() *
                                     static_cast<std::size_t>(side * side));
      (void)Network(*out.onnx_, out.card_).run(zeros, side, side);
    });
  } catch (const Error& error) {
    throw error.with_context("the model " + onnx.string());
  }
  return out;
}

}  // namespace beatlas::prior
