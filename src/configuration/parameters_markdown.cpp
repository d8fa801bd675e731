#include <string>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/configuration/parameter_text.h"

namespace cvg {
namespace {

/// Text for a cell of a table.
std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string rangeText(const Parameter& parameter) {
  const bool is_number = std::holds_alternative<double*>(parameter.target) ||
                         std::holds_alternative<std::vector<double>*>(parameter.target);
  return is_number ? parameter.range.text() : allowedText(parameter);
}

std::string row(const Parameter& parameter) {
  const std::string initial =
      parameter.required ? "**required**" : "`" + valueText(parameter) + "`";
  const bool has_unit = std::holds_alternative<double*>(parameter.target) ||
                        std::holds_alternative<std::vector<double>*>(parameter.target);
  return "| `" + parameter.key + "` | " + initial + " | " + (has_unit ? parameter.unit : "") +
         " | " + cell(rangeText(parameter)) + " | " + cell(parameter.description) + " |\n";
}

}  // namespace

std::string parametersMarkdown() {
  LoopConfiguration configuration;
  NodeParameters node;
  Sections sections = configuration.sections();
  sections.push_back({"node", {}});
  node.declare(sections.back().table);

  std::string page =
      "# Parameters\n\n"
      "One YAML file configures the nodes and the offline tools. All values are in SI units. A "
      "value that\n"
      "is unknown, missing, mistyped or out of range stops the program with a line for each.\n\n"
      "This page is printed by `rosrun ring_gyro simulate --parameters`.\n";
  for (const Section& section : sections) {
    page += "\n## " + section.name + "\n\n";
    if (section.table.parameters().empty()) continue;
    page += "| key | default | unit | allowed | meaning |\n|---|---|---|---|---|\n";
    for (const Parameter& parameter : section.table.parameters()) page += row(parameter);
  }
  return page;
}

}  // namespace cvg
