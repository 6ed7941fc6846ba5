#pragma once
/// How files and folders appear in messages: technicians and archives name them after patients.

#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_set>

namespace beatlas::ingest {

/// The words of a source's text attributes, to know identity where a path repeats it.
/// A value: collect one a thread and merge; the order does not matter.
class IdentityWords {
 public:
  /// Takes in the words of a text: runs of ASCII letters and digits, in any case, and the letters
  /// and digits of a run that mixes both ("P4711" also counts as "4711").
  void add_text(std::string_view text);
  /// Takes in a UID: its numbers count only as whole words of a path.
  void add_uid(std::string_view uid);
  void merge(const IdentityWords& other);

  /// Whether a file's or folder's name may tell who the patient is: it
  /// - has a word (3 letters or digits and more) of the texts, or a run of letters that holds one
  /// of
  ///   4 and more; words of the trade ("cine", "series") do not count;
  /// - has a number of 5 digits or more after leading zeros (a date, an ID, a UID), a '^' or a
  ///   character beyond ASCII.
  [[nodiscard]] bool identify(std::string_view name) const;

 private:
  std::unordered_set<std::string> words_;    ///< lower case, of texts and UIDs
  std::unordered_set<std::string> letters_;  ///< words of texts that hold a letter, lower case
  std::unordered_set<std::string> numbers_;  ///< digits of texts, without leading zeros
};

/// The path as messages may show it: a component that may carry identity (see IdentityWords)
/// becomes "[file 12 of 25 by name]" or "[folder 2 of 3 by name]", counted among the files or
/// folders of its folder in the order of their bytes, and keeps an extension like ".dcm";
/// "[name not shown]" if the folder cannot be listed.
[[nodiscard]] std::string shown_path(const std::filesystem::path& path,
                                     const IdentityWords& words = {});

}  // namespace beatlas::ingest
