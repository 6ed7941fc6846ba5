#pragma once
/// A network that says what voxels are likely to be: NAME.onnx, and NAME.json beside it that tells
/// what it takes and gives (schemas/prior_model.schema.json, pipeline/prior/README.md).

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace beatlas::prior {

/// What a plane of the input shows, see the room's README.
enum class Channel { Frame, Below, Above, Mean, Deviation };

/// Brightness is shown as its square root, where nothing speaks for another tone.
inline constexpr float kUsualTone = 0.5F;

/// What NAME.json says.
struct ModelCard {
  double pixel_mm = 2;                ///< [mm] 0.5..10: pixels of input and output, in plane
  std::vector<Channel> channels;      ///< of the input, in its order
  std::vector<std::uint8_t> outputs;  ///< atlas Label of each plane of the output
  double neighbour_mm = 8;            ///< [mm] 4..20: from `frame` to `below` and `above`
  int multiple = 16;                  ///< 1..256: of height and width of the input
  /// 1..8: in so many of kOrientations a slice is shown, and their probabilities averaged. More
  /// than 1 for networks that were trained on slices turned in any way.
  int orientations = 1;
  /// [ml] 0..1000, ascending: blood of the smallest and the largest LV, where they hold most, that
  /// the network was trained on. Hearts smaller than these are shown larger; 0: as they are.
  std::array<double, 2> lv_ml{0, 0};
  /// 0.2..2: exponents of brightness in which an exam may be shown, the first one the usual one.
  std::vector<float> tones{kUsualTone};
  std::string sha256;                              ///< of NAME.onnx
  nlohmann::json card = nlohmann::json::object();  ///< strings and numbers, for people
};

/// @throws Error{InvalidInput} naming the JSON path of an unknown key, a wrong type or range
[[nodiscard]] ModelCard model_card_from_json(const nlohmann::json& json);

/// A model that was read, checked and tried on an image of zeros. Cheap to copy.
class Model {
 public:
  /// @param onnx NAME.onnx
  /// @throws Error{InvalidInput} naming the file: one of the two is missing or cut, is no ONNX or
  /// JSON, they do not belong together, or the network takes or gives something else than
  /// NAME.json says or has a layer that cannot be run
  [[nodiscard]] static Model load(const std::filesystem::path& onnx);

  [[nodiscard]] const std::string& sha256() const { return card_.sha256; }
  [[nodiscard]] const ModelCard& card() const { return card_; }
  /// The bytes of NAME.onnx.
  [[nodiscard]] const std::vector<std::byte>& onnx() const { return *onnx_; }

 private:
  ModelCard card_;
  std::shared_ptr<const std::vector<std::byte>> onnx_;
};

/// NAME.json of NAME.onnx.
[[nodiscard]] std::filesystem::path card_path(const std::filesystem::path& onnx);

/// Our own weights: share/beatlas/heart_prior.onnx of the installation that the program belongs
/// to, else where the sources of this build keep them.
/// @throws Error{InvalidInput} if there are none: never silently without
[[nodiscard]] std::filesystem::path default_model_path();

}  // namespace beatlas::prior
