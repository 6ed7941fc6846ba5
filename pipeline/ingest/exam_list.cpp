#include "pipeline/ingest/exam_list.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>

#include "pipeline/ingest/series_list.h"
#include "pipeline/ingest/stack_candidates.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostListed = 12;

/// What decides to which exam an image belongs.
struct Origin {
  std::string patient;
  std::string study;
  std::string frame;

  bool operator<(const Origin& other) const {
    return std::tie(patient, study, frame) < std::tie(other.patient, other.study, other.frame);
  }
};

class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  [[nodiscard]] std::size_t of(std::size_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    const std::size_t root_a = of(a);
    const std::size_t root_b = of(b);
    parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  }

 private:
  std::vector<std::size_t> parent_;
};

bool linked(const Origin& a, const Origin& b) {
  return (!a.study.empty() && a.study == b.study) || (!a.frame.empty() && a.frame == b.frame);
}

/// What a patient is called where a part, ID or name, is blank: as the only patient of the same
/// study or frame of reference is that agrees in the other part.
std::vector<std::string> full_patients(const std::vector<Origin>& origins) {
  const auto parts = [](const std::string& patient) {
    const auto gap = patient.find('\n');
    return gap == std::string::npos ? std::pair(patient, std::string())
                                    : std::pair(patient.substr(0, gap), patient.substr(gap + 1));
  };
  std::vector<std::string> out;
  for (const Origin& origin : origins) {
    out.push_back(origin.patient);
    const auto [id, name] = parts(origin.patient);
    if (id.empty() == name.empty()) continue;
    std::set<std::string> full;
    for (const Origin& other : origins) {
      const auto [other_id, other_name] = parts(other.patient);
      if (other_id.empty() || other_name.empty() || !linked(origin, other)) continue;
      if (id.empty() ? name == other_name : id == other_id) full.insert(other.patient);
    }
    if (full.size() == 1) out.back() = *full.begin();
  }
  return out;
}

/// Joins origins of one patient that name one study or frame of reference.
void join_linked(const std::vector<Origin>& origins, Sets& sets) {
  const std::size_t count = origins.size();
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      if (origins[a].patient == origins[b].patient && linked(origins[a], origins[b])) {
        sets.join(a, b);
      }
    }
  }
}

/// Joins origins without a study's UID to the only exam that the patient has otherwise.
void join_without_study(const std::vector<Origin>& origins, Sets& sets) {
  const std::size_t count = origins.size();
  std::map<std::string, std::vector<std::size_t>> loose;
  for (std::size_t i = 0; i < count; ++i) {
    if (origins[i].study.empty()) loose[origins[i].patient].push_back(i);
  }
  for (const auto& [patient, members] : loose) {
    std::set<std::size_t> named;
    for (std::size_t i = 0; i < count; ++i) {
      if (origins[i].patient == patient && !origins[i].study.empty()) named.insert(sets.of(i));
    }
    if (named.size() > 1) continue;
    for (const std::size_t i : members) sets.join(i, named.empty() ? members[0] : *named.begin());
  }
}

/// The set of the patient whose study or frame of reference the i-th set shares, if it is one.
std::optional<std::size_t> only_host(const std::vector<Origin>& origins, const Sets& sets,
                                     std::size_t i) {
  std::set<std::string> patients;
  std::set<std::size_t> hosts;
  for (std::size_t j = 0; j < origins.size(); ++j) {
    if (origins[j].patient.empty()) continue;
    for (std::size_t k = 0; k < origins.size(); ++k) {
      if (sets.of(k) != sets.of(i) || !linked(origins[k], origins[j])) continue;
      patients.insert(origins[j].patient);
      hosts.insert(sets.of(j));
    }
  }
  if (patients.size() != 1 || hosts.size() != 1) return {};
  return *hosts.begin();
}

/// Joins origins without a patient to the only patient of the study or frame of reference.
void join_without_patient(const std::vector<Origin>& origins, Sets& sets) {
  const Sets before = sets;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    if (!origins[i].patient.empty()) continue;
    if (const auto host = only_host(origins, before, i)) sets.join(i, *host);
  }
}

/// Joins origins; the result does not depend on their order.
Sets joined(const std::vector<Origin>& origins) {
  Sets out(origins.size());
  join_linked(origins, out);
  join_without_study(origins, out);
  join_without_patient(origins, out);
  return out;
}

std::set<int> series_of(const std::vector<DicomImage>& images, const std::vector<int>& members) {
  std::set<int> out;
  for (const int i : members) out.insert(images[static_cast<std::size_t>(i)].series_number);
  return out;
}

std::string told(const std::vector<DicomImage>& images, const ExamGroup& exam) {
  std::map<std::pair<int, int>, int> sizes;
  std::set<std::string> series;
  for (const int i : exam.images) {
    const DicomImage& image = images[static_cast<std::size_t>(i)];
    ++sizes[{image.columns, image.rows}];
    series.insert(image.series_uid);
  }
  const auto usual = std::max_element(
      sizes.begin(), sizes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  std::string out = std::to_string(exam.images.size());
  out += exam.images.size() == 1 ? " image of " : " images of ";
  out += series_list(series_of(images, exam.images));
  if (series.size() > 1) out += " (" + std::to_string(series.size()) + " in all)";
  out += sizes.size() > 1 ? ", mostly " : ", ";
  out += std::to_string(usual->first.first) + " x " + std::to_string(usual->first.second);
  return out + " pixels";
}

std::vector<DicomImage> taken(const std::vector<DicomImage>& images,
                              const std::vector<int>& members) {
  std::vector<DicomImage> out;
  out.reserve(members.size());
  for (const int i : members) out.push_back(images[static_cast<std::size_t>(i)]);
  return out;
}

/// The folder that holds all files of an exam.
fs::path folder_of(const std::vector<DicomImage>& images, const ExamGroup& exam) {
  std::optional<fs::path> out;
  for (const int i : exam.images) {
    const fs::path folder = images[static_cast<std::size_t>(i)].file.parent_path();
    if (!out) out = folder;
    const auto end = std::mismatch(out->begin(), out->end(), folder.begin(), folder.end()).first;
    fs::path shared;
    for (auto part = out->begin(); part != end; ++part) shared /= *part;
    out = shared;
  }
  return out.value_or(fs::path());
}

bool lies_in(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
         folder.end();
}

/// Where the files of each exam lie: a folder that holds no other exam's, else the first of the
/// files.
std::vector<std::string> places_told(const std::vector<DicomImage>& images,
                                     const std::vector<ExamGroup>& exams, const ImageFiles& files) {
  std::vector<fs::path> folders;
  for (const ExamGroup& exam : exams) folders.push_back(folder_of(images, exam));
  std::vector<std::string> out;
  for (std::size_t e = 0; e < exams.size(); ++e) {
    bool alone = !folders[e].empty();
    for (std::size_t other = 0; other < exams.size() && alone; ++other) {
      alone = other == e ||
              std::none_of(exams[other].images.begin(), exams[other].images.end(), [&](int i) {
                return lies_in(images[static_cast<std::size_t>(i)].file, folders[e]);
              });
    }
    if (alone) {
      out.push_back("in " + files.shown(folders[e]));
      continue;
    }
    fs::path first = images[static_cast<std::size_t>(exams[e].images.front())].file;
    for (const int i : exams[e].images) {
      first = std::min(first, images[static_cast<std::size_t>(i)].file);
    }
    out.push_back("one of them " + files.shown(first));
  }
  return out;
}

/// The shape of the best stack, with a comma before it; nothing where there is none.
std::string stack_told(const std::vector<DicomImage>& images, const ImageFiles& files) {
  try {
    const Stacks stacks = find_stacks(images, files);
    return stacks.candidates.empty() ? "" : ", " + stacks.candidates.front().shape_told();
  } catch (const Error&) {
    return "";  // slices of several sizes: what they are is told when they are chosen
  }
}

/// All that tells one exam from another and is nobody's identity.
std::string list(const std::vector<DicomImage>& images, const std::vector<ExamGroup>& exams,
                 const ImageFiles& files) {
  const std::vector<std::string> places = places_told(images, exams, files);
  std::string out;
  for (std::size_t e = 0; e < exams.size() && e < kMostListed; ++e) {
    out += (e == 0 ? "" : "; ") + std::to_string(e + 1) + ". " + told(images, exams[e]) +
           stack_told(taken(images, exams[e].images), files) + ", " + places[e];
  }
  if (exams.size() > kMostListed) {
    out += "; " + std::to_string(exams.size() - kMostListed) + " more";
  }
  return out;
}

[[noreturn]] void ask(const std::vector<DicomImage>& images, const std::vector<ExamGroup>& exams,
                      const ImageFiles& files) {
  std::set<std::string> patients;
  for (const ExamGroup& exam : exams) patients.insert(exam.patient);
  throw_invalid("it holds " + std::to_string(exams.size()) + " exams" +
                (patients.size() > 1 ? " of different patients" : " of one patient") +
                ", choose one with --exam N: " + list(images, exams, files));
}

/// Takes images of other series out of the exams; exams keep their numbers.
void keep_series(const std::vector<DicomImage>& images, const std::vector<int>& series,
                 std::vector<ExamGroup>& exams) {
  if (series.empty()) return;
  bool any = false;
  std::set<int> exist;
  for (ExamGroup& exam : exams) {
    exist.merge(series_of(images, exam.images));
    std::erase_if(exam.images, [&](int i) {
      return std::count(series.begin(), series.end(),
                        images[static_cast<std::size_t>(i)].series_number) == 0;
    });
    any = any || !exam.images.empty();
  }
  if (!any) {
    throw_invalid("no image is of " + series_list({series.begin(), series.end()}) +
                  " as --series asks: there are " + series_list(exist));
  }
}

/// Of several studies of one patient: which to take.
ExamChoice choose_study(const std::vector<DicomImage>& images, const std::vector<ExamGroup>& all,
                        const std::vector<std::size_t>& left,
                        const std::function<bool(const std::vector<DicomImage>&)>& holds_stack,
                        const ImageFiles& files) {
  ExamChoice out;
  std::vector<std::size_t> holding;
  std::vector<int> together;
  for (const std::size_t e : left) {
    if (holds_stack(taken(images, all[e].images))) holding.push_back(e);
    together.insert(together.end(), all[e].images.begin(), all[e].images.end());
  }
  if (holding.size() == 1) {
    out.images = taken(images, all[holding.front()].images);
    out.decisions.push_back("There are " + std::to_string(left.size()) +
                            " studies of one patient; only one holds a stack and was taken: " +
                            told(images, all[holding.front()]) + '.');
    return out;
  }
  std::sort(together.begin(), together.end());
  if (holding.empty()) {
    out.images = taken(images, together);
    if (holds_stack(out.images)) {
      out.decisions.push_back(
          "Warning: there are " + std::to_string(left.size()) +
          " studies of one patient, none of which holds a stack; they were taken together.");
      return out;
    }
  }
  ask(images, all, files);
}

}  // namespace

std::vector<ExamGroup> list_exams(const std::vector<DicomImage>& images) {
  std::map<Origin, std::vector<int>> by_origin;
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const DicomImage& image = images[static_cast<std::size_t>(i)];
    by_origin[{image.patient, image.study_uid, image.frame_of_reference_uid}].push_back(i);
  }
  std::vector<Origin> origins;
  origins.reserve(by_origin.size());
  for (const auto& [origin, members] : by_origin) origins.push_back(origin);
  const std::vector<std::string> patients = full_patients(origins);
  std::vector<Origin> resolved = origins;
  for (std::size_t o = 0; o < origins.size(); ++o) resolved[o].patient = patients[o];
  const Sets sets = joined(resolved);
  std::map<std::size_t, ExamGroup> groups;
  for (std::size_t o = 0; o < origins.size(); ++o) {
    ExamGroup& group = groups[sets.of(o)];
    const auto& members = by_origin[origins[o]];
    group.images.insert(group.images.end(), members.begin(), members.end());
    if (group.patient.empty()) group.patient = patients[o];
  }
  std::vector<ExamGroup> out;
  for (auto& [root, group] : groups) {
    std::sort(group.images.begin(), group.images.end());
    out.push_back(std::move(group));
  }
  const auto rank = [&](const ExamGroup& group) {
    const DicomImage& first = images[static_cast<std::size_t>(group.images.front())];
    return std::make_tuple(-static_cast<long>(group.images.size()), first.series_number,
                           first.series_uid, first.study_uid, group.patient);
  };
  std::sort(out.begin(), out.end(),
            [&](const ExamGroup& a, const ExamGroup& b) { return rank(a) < rank(b); });
  return out;
}

ExamChoice choose_exam(const std::vector<DicomImage>& images, int exam,
                       const std::vector<int>& series,
                       const std::function<bool(const std::vector<DicomImage>&)>& holds_stack,
                       const ImageFiles& files) {
  const std::vector<ExamGroup> all = list_exams(images);
  if (exam > static_cast<int>(all.size())) {
    throw_invalid("there is no exam " + std::to_string(exam) + " (--exam), only " +
                  list(images, all, files));
  }
  std::vector<ExamGroup> wanted = all;
  if (exam > 0) wanted = {all[static_cast<std::size_t>(exam) - 1]};
  keep_series(images, series, wanted);
  std::vector<std::size_t> left;
  std::set<std::string> patients;
  for (std::size_t e = 0; e < wanted.size(); ++e) {
    if (wanted[e].images.empty()) continue;
    left.push_back(e);
    patients.insert(wanted[e].patient);
  }
  if (left.size() > 1) {
    if (patients.size() > 1 || patients.count("") > 0) ask(images, all, files);
    return choose_study(images, wanted, left, holds_stack, files);
  }
  ExamChoice out;
  out.images = taken(images, wanted[left.front()].images);
  if (exam > 0 && all.size() > 1) {
    out.decisions.push_back("Exam " + std::to_string(exam) + " of " + std::to_string(all.size()) +
                            " was taken, as asked.");
  }
  return out;
}

}  // namespace beatlas::ingest
