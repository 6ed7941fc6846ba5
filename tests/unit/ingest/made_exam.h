#pragma once
/// Exams written by make_exam.py and what they must read back as.

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/ingest/ingest.h"
#include "pipeline/ingest/shown_path.h"
#include "runtime/base/error.h"
#include "tests/unit/formats/python_run.h"

namespace beatlas::ingest::test {

using beatlas::test::Folder;

class MadeExam {
 public:
  explicit MadeExam(const std::string& variant)
      : variant_(variant),
        path_(folder_ / (variant.rfind("nifti", 0) == 0 ? "exam.nii.gz" : "exam")) {
    truth_ = beatlas::test::run_python(std::string(BEATLAS_TEST_SCRIPTS) + "/make_exam.py",
                                       variant + ' ' + beatlas::test::quoted(path_),
                                       folder_ / "truth.json");
  }
  [[nodiscard]] const std::string& variant() const { return variant_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] const nlohmann::json& truth() const { return truth_; }
  [[nodiscard]] Exam read(const IngestOptions& options = {}) const {
    StageContext context;
    return read_exam({path_}, options, context);
  }
  /// The message read_exam refuses it with; also checks its code and that it tells no secret.
  [[nodiscard]] std::string refusal(const IngestOptions& options = {}) const {
    try {
      (void)read(options);
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      EXPECT_EQ(message.find("SECRET"), std::string::npos) << message;
      EXPECT_EQ(message.find("secret"), std::string::npos) << message;
      EXPECT_EQ(message.rfind(path_.string(), 0), 0U) << "names the place as typed: " << message;
      return message;
    }
    return "was read";
  }

  [[nodiscard]] Affine lps_from_index() const {
    Affine out = Affine::Identity();
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) {
        out.matrix()(r, c) =
            truth_["lps_from_index"][static_cast<std::size_t>(r)][static_cast<std::size_t>(c)]
                .get<double>();
      }
    }
    return out;
  }
  /// Brightness of the object at a place, before the beat.
  [[nodiscard]] double brightness(const Vec3& lps) const {
    double out = 100;
    for (const auto& blob : truth_["blobs"]) {
      const auto c = blob["lps"].get<std::vector<double>>();
      const double sigma = blob["sigma"];
      const double r2 = (lps - Vec3(c[0], c[1], c[2])).squaredNorm();
      out += blob["height"].get<double>() * std::exp(-r2 / (2 * sigma * sigma));
    }
    return out;
  }
  /// Largest |voxel - truth| of a cine, in units of brightness.
  /// @param but a slice that is not looked at; -1: all are
  [[nodiscard]] double worst_error(const Cine& cine, int but = -1) const {
    const Grid& grid = cine.grid();
    double worst = 0;
    for (int p = 0; p < cine.phase_count(); ++p) {
      const double beat = 1 + 0.3 * std::cos(2 * std::numbers::pi * p / cine.phase_count());
      for (int k = 0; k < grid.size[2]; ++k) {
        if (k == but) continue;
        for (int j = 0; j < grid.size[1]; ++j) {
          for (int i = 0; i < grid.size[0]; ++i) {
            const double value =
                cine.images.phases[static_cast<std::size_t>(p)][grid.offset(i, j, k)];
            worst = std::max(worst, std::abs(value - beat * brightness(grid.mm(i, j, k))));
          }
        }
      }
    }
    return worst;
  }

 private:
  Folder folder_;
  std::string variant_;
  std::filesystem::path path_;
  nlohmann::json truth_;
};

/// Whether a decision contains the words.
inline bool decided(const Exam& exam, const std::string& words) {
  for (const std::string& decision : exam.decisions) {
    if (decision.find(words) != std::string::npos) return true;
  }
  return false;
}

inline std::string all(const Exam& exam) {
  std::string out;
  for (const std::string& decision : exam.decisions) out += "  " + decision + '\n';
  return out;
}

/// Half a grey level, because files hold whole numbers. The steepest edge of the object has 360
/// grey levels a mm, so this also bounds a shift to 0.002 mm.
inline constexpr double kRounding = 0.51;

}  // namespace beatlas::ingest::test
