#include <string>
#include <string_view>

#include "pipeline/report/page_files.h"
#include "pipeline/report/report_data.h"

namespace beatlas::report {
namespace {

/// Puts `with` where `mark` stands in the page.
void put(std::string& page, std::string_view mark, std::string_view with) {
  const std::size_t at = page.find(mark);
  if (at != std::string::npos) page.replace(at, mark.size(), with);
}

/// As the content of a script element: no text in it can end the element.
std::string in_script(const nlohmann::json& json) {
  std::string out;
  for (const char c : json.dump(-1, ' ', true)) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string report_html(const nlohmann::json& report) {
  std::string page(page_file("report.html"));
  // The data come last: whatever they hold is not searched for marks.
  for (const char* file : {"report.css", "three.min.js", "OrbitControls.js", "parts.js",
                           "charts.js", "slices.js", "heart.js", "report.js"}) {
    put(page, std::string("{{") + file + "}}", page_file(file));
  }
  put(page, "{{data}}", in_script(report));
  return page;
}

}  // namespace beatlas::report
