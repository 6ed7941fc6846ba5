#include "tests/unit/prior/made_models.h"

#include <fstream>
#include <span>
#include <sstream>

#include "pipeline/prior/model.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/base/sha256.h"

namespace beatlas::prior::made {
namespace fs = std::filesystem;
namespace {

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

}  // namespace

fs::path model_file(const std::string& name) {
  return fs::path(BEATLAS_PRIOR_MODELS) / (name + ".onnx");
}

double weight(int output, int channel) {
  return ((7 * output + 3 * channel * channel + 5 * output * channel + 5) % 11 - 5) * 0.5;
}

double bias(int output) { return ((5 * output + 2) % 7 - 3) * 0.25; }

Folder::Folder() {
  std::string pattern = (fs::temp_directory_path() / "beatlas-prior-XXXXXX").string();
  path_ = mkdtemp(pattern.data());
}

Folder::~Folder() { fs::remove_all(path_); }

fs::path Folder::copy_of(const std::string& name,
                         const std::function<void(std::string&)>& change_onnx,
                         const std::function<void(nlohmann::json&)>& change_card) const {
  const fs::path to = path_ / (name + ".onnx");
  std::string onnx = text_of(model_file(name));
  if (change_onnx) change_onnx(onnx);
  std::ofstream(to, std::ios::binary) << onnx;
  nlohmann::json card = parse_json(text_of(card_path(model_file(name))));
  card["sha256"] = sha256_hex(std::as_bytes(std::span(onnx)));
  if (change_card) change_card(card);
  std::ofstream(card_path(to)) << json_text(card);
  return to;
}

Grid turned_grid(const Index3& size, const Vec3& spacing_mm) {
  Grid out;
  out.size = size;
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.4, Vec3::UnitX()) * Eigen::AngleAxisd(-0.7, Vec3::UnitY()) *
       Eigen::AngleAxisd(1.1, Vec3::UnitZ()))
          .toRotationMatrix();
  out.mm_from_index.linear() = turn * spacing_mm.asDiagonal();
  out.mm_from_index.translation() = Vec3(-31, 12, 77);
  return out;
}

Exam rough_exam(const Grid& grid, int phases) {
  Exam out;
  out.stack.images.grid = grid;
  out.stack.rr_interval_s = 0.8;
  std::uint32_t state = 12345;
  for (int p = 0; p < phases; ++p) {
    std::vector<float>& image = out.stack.images.phases.emplace_back(grid.count());
    for (float& value : image) {
      state = state * 1664525U + 1013904223U;
      value = 40 + static_cast<float>(state >> 8U) / 40000.0F;
    }
  }
  return out;
}

testing::AssertionResult tells(const std::string& said, const std::string& words) {
  if (said.find(words) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "\"" << said << "\" lacks \"" << words << "\"";
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    const std::string said = error.what();
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    EXPECT_LT(said.size(), 600U) << said;
    return said;
  }
  ADD_FAILURE() << "nothing was refused";
  return {};
}

}  // namespace beatlas::prior::made
