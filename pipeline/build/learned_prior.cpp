#include "pipeline/build/learned_prior.h"

#include <filesystem>
#include <utility>

#include "pipeline/motion/bad_frames.h"
#include "pipeline/segment/known_labels.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr auto kNone = "none";

std::string& usual_word() {
  static std::string word;
  return word;
}

/// What the recipe says, else what holds for all exams; empty: the built-in one.
std::string word_of(const Recipe& recipe) {
  return recipe.segment.prior.empty() ? usual_word() : recipe.segment.prior;
}

/// @pre the word names a model
fs::path model_path(const std::string& word) {
  return word.empty() ? prior::default_model_path() : fs::path(word);
}

std::optional<prior::Model> model_of(const Recipe& recipe) {
  const std::string word = word_of(recipe);
  if (word == kNone) return std::nullopt;
  return prior::Model::load(model_path(word));
}

/// What the study's segmentation was made with; empty: there is none.
std::string made_with(const study::Study* study) {
  const study::StageRecord* record =
      study == nullptr ? nullptr : study->find(study::Stage::Segment);
  if (record == nullptr) return {};
  const auto option = record->options.find(kPriorOption);
  return option != record->options.end() && option->is_string() ? option->get<std::string>()
                                                                : std::string();
}

}  // namespace

void set_usual_prior(std::string word) { usual_word() = std::move(word); }

void note_prior(Orders& orders, const study::Study* study) {
  const std::string word = word_of(orders.recipe);
  orders.prior_sha256 = kNone;
  if (word == kNone) return;
  try {
    orders.prior_sha256 = study::sha256_of_file(model_path(word));
  } catch (const Error&) {  // whoever needs the model itself says so
    const json of_study = study != nullptr && study->recipe() ? *study->recipe() : json::object();
    const json segment = of_study.value("segment", json::object());
    const bool same =
        segment.contains(kPriorOption) && segment.at(kPriorOption) == orders.recipe.segment.prior;
    orders.prior_sha256 = same ? made_with(study) : std::string();
  }
}

void check_prior(const Recipe& recipe) { (void)model_of(recipe); }

void check_prior(const Orders& orders, const study::Study* study) {
  if (orders.prior_sha256.empty() || made_with(study) != orders.prior_sha256) {
    check_prior(orders.recipe);
  }
}

std::optional<prior::PriorCycle> prior_of(const Exam& exam, const Recipe& recipe,
                                          StageContext context) {
  const std::optional<prior::Model> model = model_of(recipe);
  if (!model) return std::nullopt;
  // A frame of noise tells the network nothing of its phase; those beside it do.
  const std::optional<Exam> mended = motion::without_bad_frames(exam);
  return prior::heart_prior(mended ? *mended : exam, *model, context);
}

bool wants_prior(const Corrections& corrections, const Recipe& recipe, int phases) {
  const segment::KnownLabels& known = corrections.known;
  const bool all =
      known.phases.size() == static_cast<std::size_t>(phases) && !segment::has_unknown(known);
  return word_of(recipe) != kNone && !all;
}

}  // namespace beatlas::build
