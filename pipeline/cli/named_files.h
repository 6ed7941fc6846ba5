#pragma once
/// Files that the words of a command name: of the kind that is asked; and packages, reports and
/// times, which replace nothing but their like.

#include <filesystem>
#include <string>

namespace beatlas::cli {

/// What a user may have at hand and name in a package's place is told by what it is, with the
/// command that takes it. What is none of that is left to the reader.
/// @throws Error{InvalidInput} for a study, another folder and an image
void refuse_what_is_no_package(const std::filesystem::path& file);

enum class OutputKind { Package, Page, Timing };

/// Refuses a file that is there and is not of the output's kind, such as an image of the exam, its
/// seeds or a recipe, and one that a study keeps for itself: its index, or a file in one of its
/// folders.
/// @param output may be empty: nothing is written then
/// @param study its folder; may be empty  @throws Error{Usage}
void refuse_to_replace(const std::string& output, OutputKind kind, const std::string& study = {});

}  // namespace beatlas::cli
