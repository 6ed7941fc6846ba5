#pragma once
/// Models of tests/unit/prior/models, exams made of nothing but arithmetic, and refusals.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "pipeline/core/exam.h"

namespace beatlas::prior::made {

/// NAME.onnx of the models kept beside the tests.
[[nodiscard]] std::filesystem::path model_file(const std::string& name);

/// What make_models.py gave the networks that look at one pixel: logit of an output.
[[nodiscard]] double weight(int output, int channel);
[[nodiscard]] double bias(int output);

/// A folder of one test's own, empty, gone with it.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  /// A copy of a model in which both files may be changed; their SHA-256 is put right.
  /// @return its .onnx
  [[nodiscard]] std::filesystem::path copy_of(
      const std::string& name, const std::function<void(std::string& onnx)>& change_onnx = {},
      const std::function<void(nlohmann::json& card)>& change_card = {}) const;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A grid turned out of all axes.
[[nodiscard]] Grid turned_grid(const Index3& size, const Vec3& spacing_mm);
/// Intensities that follow no pattern, the same in every run.
[[nodiscard]] Exam rough_exam(const Grid& grid, int phases);

/// Whether a message holds some words.
[[nodiscard]] testing::AssertionResult tells(const std::string& said, const std::string& words);

/// Message of the Error of kind InvalidInput that `call` throws; fails the test if there is none,
/// or if it is not one line.
[[nodiscard]] std::string refusal(const std::function<void()>& call);

}  // namespace beatlas::prior::made
