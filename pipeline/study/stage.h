#pragma once
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace beatlas::study {

/// What a study goes through. All but Pictures, which comes with `segment`, have a command of
/// their name.
enum class Stage { Import, Segment, Pictures, Register, Field, Mesh, Pack };

inline constexpr std::array kAllStages{Stage::Import,   Stage::Segment, Stage::Pictures,
                                       Stage::Register, Stage::Field,   Stage::Mesh,
                                       Stage::Pack};

/// "import", "segment", "pictures", "register", "field", "mesh", "pack".
[[nodiscard]] std::string_view stage_name(Stage stage) noexcept;
/// The command that runs it.
[[nodiscard]] std::string_view stage_command(Stage stage) noexcept;

/// The stages whose outputs a stage reads.
[[nodiscard]] std::vector<Stage> sources_of(Stage stage);

/// Whether a stage reads an output, named as in study.json, of one of its sources.
[[nodiscard]] bool reads(Stage stage, Stage source, std::string_view file) noexcept;

/// The labels as the stage segment made them, beside labels.nii.gz which may be edited.
inline constexpr auto kLabelsAsMade = "segment/labels_as_made.nii.gz";

/// The labels as made, on the slices where they were acquired, if import moved any; for the eye.
inline constexpr auto kLabelsAsAcquired = "segment/labels_source.nii.gz";

/// Whether an output, named as in study.json, is there to be looked at only, or to save a stage's
/// next run time: no other stage reads it.
[[nodiscard]] bool for_the_eye(std::string_view file) noexcept;

}  // namespace beatlas::study
