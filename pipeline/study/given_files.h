#pragma once
/// Label images and coverage that a user gave, kept in the study so that a stage can run again
/// without them:
/// given/HASH.nii.gz each, and what tells of them in study.json. Nothing there names where they
/// came from.

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/shapes.h"

namespace beatlas::study {

struct GivenLabels {
  LabelCycle images;  ///< on their own grid, patient LPS
  std::vector<int>
      phases;  ///< of each image; -1 = every phase; empty: each of the study's, in order
  std::string file_sha256;  ///< of the file they were read from, as it was; of several: `sha256`
  std::string sha256;       ///< of grid, voxels and phases, see given_sha256
};

/// Coverage of one structure in each phase of the study.
struct GivenImages {
  ImageCycle<float> images;  ///< on their own grid, patient LPS
  std::string file_sha256;
  std::string sha256;
};

/// SHA-256 of what the images say, whatever file they came in.
[[nodiscard]] std::string given_sha256(const LabelCycle& images, const std::vector<int>& phases);
[[nodiscard]] std::string given_sha256(const ImageCycle<float>& images);

/// Writes the images, if they are not there yet; gives what study.json keeps of them.
/// @throws Error{Machine}
[[nodiscard]] nlohmann::json write_given(const std::filesystem::path& study,
                                         const GivenLabels& given);
[[nodiscard]] nlohmann::json write_given(const std::filesystem::path& study,
                                         const GivenImages& given);

/// @param json as write_given gave it; @param path of it in study.json, for messages
/// @throws Error{InvalidInput} if the images are gone or are not what was written, saying to give
/// them again.
[[nodiscard]] GivenLabels read_given(const std::filesystem::path& study, const nlohmann::json& json,
                                     const std::string& path);
[[nodiscard]] GivenImages read_given_images(const std::filesystem::path& study,
                                            const nlohmann::json& json, const std::string& path);

/// Removes images of given/ but those that one of `kept`, objects by name as Study::given, tells
/// of.
void clear_given(const std::filesystem::path& study, const std::vector<nlohmann::json>& kept);

}  // namespace beatlas::study
