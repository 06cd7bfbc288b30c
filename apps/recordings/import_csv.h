/// @file
/// A folder of CSV files, one per sensor.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/recordings/import.h"
#include "apps/recordings/survey.h"

namespace leadline::app {

/// Reads what is there of these files. Each has a header line, then rows in the order of time; times are
/// seconds since any epoch, all else SI units and radians. Columns may have any order.
///
/// | file              | columns            | and, if known                                 |
/// |-------------------|--------------------|-----------------------------------------------|
/// | heading.csv       | t,heading          | sigma (empty: as configured)                  |
/// | speed.csv         | t,speed            | sigma                                         |
/// | body_velocity.csv | t,surge,sway       | surge_sigma, sway_sigma                       |
/// | yaw_rate.csv      | t,yaw_rate         | sigma                                         |
/// | velocity.csv      | t,v,omega          | held until the next row                       |
/// | ackermann.csv     | t,v,steering       | likewise                                      |
/// | odometry.csv      | t,dx,dy,dheading   | since the previous row, in the body frame     |
/// |                   |                    | at that time                                  |
/// | range_sonar.csv   | t,channel,range    | sigma, confidence (0 to 1; empty: unknown),   |
/// |                   |                    | label (empty: unknown). channel: name of the  |
/// |                   |                    | sensor; empty range: a ping without echo      |
/// | range_bearing.csv | t,range,bearing    | id (empty: unknown); empty range: a scan that |
/// |                   |                    | saw nothing                                   |
/// | truth.csv         | t,x,y              | heading                                       |
/// | landmarks.csv     | id,x,y             | true points                                   |
///
/// Rows of range_sonar.csv and range_bearing.csv with equal times are one scan. Something tells how the
/// vehicle moves: one of velocity, ackermann and odometry, or speed, body_velocity, or what is seen from it.
/// Sensors are the channels of range_sonar.csv in the order in which they appear, then one named
/// "range_bearing" if there is such a file.
///
/// Read over, and said in the notes: a few rows that are not in the order of time, or have the time of the
/// row before; a range that is negative or infinite, for no echo. Refused: tables with other names, headings
/// beyond 2 pi of an unsaid unit, files whose times do not overlap; ImportOptions say otherwise.
/// @throws std::runtime_error naming file, line, column, value and what is allowed; so does what it returns.
std::unique_ptr<ImportSource> open_csv(const std::filesystem::path& folder, const ImportOptions& options);

/// All of it.
Import import_csv(const std::filesystem::path& folder, const ImportOptions& options = {});

/// What is in the folder, file by file, whatever is wrong with it.
/// @param[out] faults of files that cannot be read, and what lies there besides.
/// @throws std::runtime_error if it is no folder.
Survey survey_csv(const std::filesystem::path& folder, const ImportOptions& options,
                  std::vector<std::string>& faults);

}  // namespace leadline::app
