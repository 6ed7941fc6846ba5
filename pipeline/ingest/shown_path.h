#pragma once
/// How files and folders appear in messages: technicians and archives name them after patients.

#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

namespace beatlas::ingest {

/// The words of a source's text attributes, to know identity where a path repeats it.
/// A value: collect one a thread and merge; the order does not matter.
class IdentityWords {
 public:
  /// Takes in the words of a text: runs of ASCII letters and digits, in any case, and the letters
  /// and digits of a run that mixes both ("P4711" also counts as "4711").
  void add_text(std::string_view text);
  /// The same for a text that is identity whatever it holds, a person's name or ID: its parts of 2
  /// letters or digits count too, as whole words ("Li", 42).
  void add_identity(std::string_view text);
  /// Takes in a UID: its numbers count only as whole words of a path.
  void add_uid(std::string_view uid);
  void merge(const IdentityWords& other);

  /// Whether a file's or folder's name may tell who the patient is: it
  /// - has a word (3 letters or digits and more) of the texts, or a run of letters that holds one
  /// of
  ///   4 and more; words of the trade ("cine", "series") do not count;
  /// - has neighbouring words that are one word of the texts, or a text's words as one word, or a
  ///   date of theirs in another order ("12-34-56" and "123456", "02.01.1980" and "19800102");
  /// - has a number of 5 digits or more after leading zeros (a date, an ID, a UID), a date written
  ///   apart, a '^' or a character beyond ASCII.
  [[nodiscard]] bool identify(std::string_view name) const;

 private:
  std::unordered_set<std::string> words_;    ///< lower case, of texts and UIDs
  std::unordered_set<std::string> letters_;  ///< words of texts that hold a letter, lower case
  std::unordered_set<std::string> numbers_;  ///< digits of texts, without leading zeros
  std::unordered_set<std::string> short_;    ///< whole words of names and IDs, zeros as above

  /// Takes in the runs of a text as one word.
  void add_joined(const std::vector<std::string>& parts);
  /// Whether a run of letters and digits, in lower case, may tell who the patient is.
  [[nodiscard]] bool identifies(const std::string& word) const;
};

/// The path as messages may show it: a component that may carry identity (see IdentityWords)
/// becomes "[file 12 of 25 by name]" or "[folder 2 of 3 by name]", counted among the files or
/// folders of its folder in the order of their bytes, and keeps an extension like ".dcm";
/// "[name not shown]" if the folder cannot be listed. A control character becomes '?'.
[[nodiscard]] std::string shown_path(const std::filesystem::path& path,
                                     const IdentityWords& words = {});

/// The path in a message to its user, which nothing keeps: the source that he typed stands as he
/// typed it, what was found below it is shown as above.
/// @param typed the sources, files or folders
[[nodiscard]] std::string shown_to(const std::vector<std::filesystem::path>& typed,
                                   const std::filesystem::path& path,
                                   const IdentityWords& words = {});

/// The path from the source on in which it lies, shown as above, for what is kept: where the source
/// lies tells whose machine it was. A source itself is its name, shown as above.
[[nodiscard]] std::string shown_below(const std::vector<std::filesystem::path>& typed,
                                      const std::filesystem::path& path,
                                      const IdentityWords& words = {});

}  // namespace beatlas::ingest
