#include "pipeline/report/normal_ranges.h"

#include <cstddef>
#include <string>

namespace beatlas::report {
using nlohmann::json;

const std::vector<NormalSource>& normal_sources() {
  static const std::vector<NormalSource> sources{
      {"Petersen 2017",
       "Petersen SE et al. Reference ranges for cardiac structure and function using "
       "cardiovascular magnetic resonance (CMR) in Caucasians from the UK Biobank population "
       "cohort. J Cardiovasc Magn Reson 2017;19:18. doi:10.1186/s12968-017-0327-9",
       "healthy adults of 45 to 74 years, SSFP cine at 1.5 T, papillary muscles counted as blood",
       Papillary::Blood},
      {"Hudsmith 2005",
       "Hudsmith LE et al. Normal human left and right ventricular and left atrial dimensions "
       "using steady state free precession magnetic resonance imaging. J Cardiovasc Magn Reson "
       "2005;7:775-782. doi:10.1080/10976640500295516",
       "63 men and 45 women, SSFP cine at 1.5 T; mean and twice the standard deviation",
       Papillary::None},
      {"Kawel-Boehm 2015",
       "Kawel-Boehm N et al. Normal values for cardiovascular magnetic resonance in adults and "
       "children. J Cardiovasc Magn Reson 2015;17:29. doi:10.1186/s12968-015-0111-7",
       "pooled healthy adults, SSFP cine, papillary muscles counted as muscle, which adds to the "
       "mass; mean and twice the standard deviation",
       Papillary::Muscle}};
  return sources;
}

const std::vector<NormalRange>& normal_ranges() {
  static const std::vector<NormalRange> ranges{
      {"lv_ef_percent", "LV ejection fraction", "%", 47, 70, 51, 70, 0},
      {"lv_edv_ml", "LV end-diastolic volume", "ml", 109, 232, 88, 161, 0},
      {"lv_esv_ml", "LV end-systolic volume", "ml", 39, 103, 31, 68, 0},
      {"lv_sv_ml", "LV stroke volume", "ml", 58, 140, 49, 100, 0},
      {"rv_edv_ml", "RV end-diastolic volume", "ml", 124, 256, 78, 218, 1},
      {"rv_esv_ml", "RV end-systolic volume", "ml", 38, 118, 20, 92, 1},
      {"lv_mass_g", "LV mass", "g", 92, 176, 56, 140, 2}};
  return ranges;
}

json normal_to_json(Papillary labelled) {
  json ranges = json::array();
  for (const NormalRange& range : normal_ranges()) {
    const Papillary papillary = normal_sources()[static_cast<std::size_t>(range.source)].papillary;
    json entry{{"figure", range.figure},
               {"title", range.title},
               {"unit", range.unit},
               {"men", {range.men_low, range.men_high}},
               {"women", {range.women_low, range.women_high}},
               {"source", range.source}};
    if (papillary != Papillary::None && papillary != labelled) {
      entry["men"] = nullptr;
      entry["women"] = nullptr;
      entry["other"] = std::string("no range: papillary muscles are ") +
                       (labelled == Papillary::Muscle ? "muscle" : "blood") + " here and " +
                       (labelled == Papillary::Muscle ? "blood" : "muscle") + " in the source";
    }
    ranges.push_back(std::move(entry));
  }
  json sources = json::array();
  for (const NormalSource& source : normal_sources()) {
    sources.push_back(
        {{"name", source.short_name}, {"citation", source.citation}, {"how", source.how}});
  }
  return {{"ranges", ranges},
          {"sources", sources},
          {"papillary", labelled == Papillary::Muscle ? "muscle" : "blood"}};
}

}  // namespace beatlas::report
