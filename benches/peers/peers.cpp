// Times MRPT and OctoMap on a file of readings and prints one JSON object.
//
//     peers PROGRAM READINGS WARM_UPS PASSES
//
// PROGRAM is one of
//   mrpt-cone    COccupancyGridMap2D, one CObservationRange a reading: the 30 degree cone as a triangle
//   mrpt-scan    COccupancyGridMap2D, one CObservation2DRangeScan a scan: a line for each beam
//   octomap-ray  OcTree::insertRay along the axis of each reading; the beam's width is lost
//   octomap-fan  OcTree::insertPointCloud of rays over the cone, one cell apart at its arc
//   octomap-scan OcTree::insertPointCloud of the beams of each scan
//
// A line of READINGS is `x y heading range`, metres and radians. Lines in a row with the same x and y are one scan.
// Everything that can be made beforehand is: poses, observations, point clouds, MRPT's grid. A pass starts on an empty
// map and takes all readings on one thread.

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationRange.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace
{
constexpr double kCell = 0.05;
constexpr double kBeamWidth = 30.0 * M_PI / 180.0;
// About so many readings are inserted one by one into an empty map to see how many cells each touches.
constexpr std::size_t kSample = 500;

struct Reading
{
    double x, y, heading, range;
};

using Readings = std::vector<Reading>;

Readings load(const std::string& path)
{
    std::ifstream file(path);
    if (!file) throw std::runtime_error("cannot read " + path);
    Readings readings;
    Reading r;
    while (file >> r.x >> r.y >> r.heading >> r.range) readings.push_back(r);
    if (readings.empty() || !file.eof()) throw std::runtime_error(path + " is not a file of readings");
    return readings;
}

// The readings split at each change of position.
std::vector<Readings> scans(const Readings& readings)
{
    std::vector<Readings> all;
    for (const Reading& r : readings)
    {
        if (all.empty() || all.back().back().x != r.x || all.back().back().y != r.y) all.emplace_back();
        all.back().push_back(r);
    }
    return all;
}

// What the timing needs of a peer: an empty map, and to insert one of its observations.
struct Peer
{
    std::size_t observations = 0;
    std::function<void()> clear;
    std::function<void(std::size_t)> insert;
    std::function<std::size_t()> touched;
    std::function<void()> check = [] {};
    std::string version;
};

// A grid with room for every reading, so that inserting never enlarges it.
struct MrptGrid
{
    mrpt::maps::COccupancyGridMap2D map;
    unsigned width = 0, height = 0;

    explicit MrptGrid(const Readings& readings)
    {
        double left = 1e9, right = -1e9, bottom = 1e9, top = -1e9;
        for (const Reading& r : readings)
        {
            left = std::min(left, r.x - r.range);
            right = std::max(right, r.x + r.range);
            bottom = std::min(bottom, r.y - r.range);
            top = std::max(top, r.y + r.range);
        }
        // MRPT enlarges a map when a reading comes within 15 cells of its border.
        const double margin = 2.0;
        map.setSize(left - margin, right + margin, bottom - margin, top + margin, kCell);
        width = map.getSizeX();
        height = map.getSizeY();
    }

    void check() const
    {
        if (map.getSizeX() != width || map.getSizeY() != height) throw std::runtime_error("MRPT resized its map");
    }

    std::size_t touched() const
    {
        const auto& cells = map.getRawMap();
        return cells.size() - std::count(cells.begin(), cells.end(), 0);
    }
};

// A grid and its observations, made before the clock starts.
template <class Observation>
struct Mrpt
{
    MrptGrid grid;
    std::vector<Observation> observations;
    std::vector<mrpt::poses::CPose3D> poses;

    explicit Mrpt(const Readings& readings) : grid(readings) {}

    void insert(std::size_t k)
    {
        if (!grid.map.insertObservation(observations[k], poses[k])) throw std::runtime_error("MRPT refused a reading");
    }
};

template <class Observation>
Peer peer(std::shared_ptr<Mrpt<Observation>> mrpt)
{
    Peer p;
    p.observations = mrpt->observations.size();
    p.clear = [mrpt] { mrpt->grid.map.fill(0.5f); };
    p.insert = [mrpt](std::size_t k) { mrpt->insert(k); };
    p.touched = [mrpt] { return mrpt->grid.touched(); };
    p.check = [mrpt] { mrpt->grid.check(); };
    p.version = "MRPT " MRPT_VERSION_TEXT;
    return p;
}

mrpt::poses::CPose3D pose(double x, double y, double heading) { return {x, y, 0.0, heading, 0.0, 0.0}; }

// The insertion options stay as they are by default: readings up to 15 m, no altitude asked for.
Peer mrpt_cone(const Readings& readings)
{
    auto mrpt = std::make_shared<Mrpt<mrpt::obs::CObservationRange>>(readings);
    for (const Reading& r : readings)
    {
        // One reading an observation: MRPT inserts all of an observation from the first one's pose.
        mrpt::obs::CObservationRange o;
        o.sensorConeApperture = static_cast<float>(kBeamWidth);
        o.maxSensorDistance = 5.0f;
        o.sensedData.emplace_back();
        o.sensedData.back().sensedDistance = static_cast<float>(r.range);
        mrpt->observations.push_back(o);
        // MRPT 2.5.8 draws the triangle from a whole width right of the heading up to it: turn it to where the beam is.
        mrpt->poses.push_back(pose(r.x, r.y, r.heading + kBeamWidth / 2.0));
    }
    return peer(mrpt);
}

Peer mrpt_scan(const Readings& readings)
{
    auto mrpt = std::make_shared<Mrpt<mrpt::obs::CObservation2DRangeScan>>(readings);
    for (const Readings& scan : scans(readings))
    {
        const double first = scan.front().heading, last = scan.back().heading;
        mrpt::obs::CObservation2DRangeScan o;
        o.aperture = static_cast<float>(last - first);
        o.rightToLeft = true;
        o.maxRange = 20.0f;
        o.resizeScan(scan.size());
        for (std::size_t k = 0; k < scan.size(); k++)
        {
            o.setScanRange(k, static_cast<float>(scan[k].range));
            o.setScanRangeValidity(k, true);
        }
        mrpt->observations.push_back(o);
        mrpt->poses.push_back(pose(scan.front().x, scan.front().y, (first + last) / 2.0));
    }
    return peer(mrpt);
}

octomap::point3d point(const Reading& r, double heading)
{
    return octomap::point3d(static_cast<float>(r.x + r.range * std::cos(heading)),
                            static_cast<float>(r.y + r.range * std::sin(heading)), 0.0f);
}

octomap::point3d origin(const Reading& r)
{
    return octomap::point3d(static_cast<float>(r.x), static_cast<float>(r.y), 0.0f);
}

// A tree, and for each observation its origin and end points. A tree can't be sized beforehand: it grows.
struct Octomap
{
    std::unique_ptr<octomap::OcTree> tree = std::make_unique<octomap::OcTree>(kCell);
    std::vector<octomap::point3d> origins;
    std::vector<octomap::Pointcloud> ends;
};

Peer peer(std::shared_ptr<Octomap> octomap, bool one_ray)
{
    Peer p;
    p.observations = octomap->ends.size();
    p.clear = [octomap] { octomap->tree = std::make_unique<octomap::OcTree>(kCell); };
    if (one_ray)
        p.insert = [octomap](std::size_t k) { octomap->tree->insertRay(octomap->origins[k], octomap->ends[k][0]); };
    else
        p.insert = [octomap](std::size_t k) { octomap->tree->insertPointCloud(octomap->ends[k], octomap->origins[k]); };
    p.touched = [octomap] { return octomap->tree->getNumLeafNodes(); };
    p.version = "OctoMap " OCTOMAP_VERSION_TEXT;
    return p;
}

Peer octomap_ray(const Readings& readings)
{
    auto octomap = std::make_shared<Octomap>();
    for (const Reading& r : readings)
    {
        octomap->origins.push_back(origin(r));
        octomap->ends.emplace_back();
        octomap->ends.back().push_back(point(r, r.heading));
    }
    return peer(octomap, true);
}

Peer octomap_fan(const Readings& readings)
{
    auto octomap = std::make_shared<Octomap>();
    for (const Reading& r : readings)
    {
        const int gaps = std::max(1, static_cast<int>(std::ceil(kBeamWidth * r.range / kCell)));
        octomap->origins.push_back(origin(r));
        octomap->ends.emplace_back();
        for (int k = 0; k <= gaps; k++)
            octomap->ends.back().push_back(point(r, r.heading + kBeamWidth * (static_cast<double>(k) / gaps - 0.5)));
    }
    return peer(octomap, false);
}

Peer octomap_scan(const Readings& readings)
{
    auto octomap = std::make_shared<Octomap>();
    for (const Readings& scan : scans(readings))
    {
        octomap->origins.push_back(origin(scan.front()));
        octomap->ends.emplace_back();
        for (const Reading& r : scan) octomap->ends.back().push_back(point(r, r.heading));
    }
    return peer(octomap, false);
}

Peer make(const std::string& program, const Readings& readings)
{
    if (program == "mrpt-cone") return mrpt_cone(readings);
    if (program == "mrpt-scan") return mrpt_scan(readings);
    if (program == "octomap-ray") return octomap_ray(readings);
    if (program == "octomap-fan") return octomap_fan(readings);
    if (program == "octomap-scan") return octomap_scan(readings);
    throw std::runtime_error("no such program: " + program);
}

// Seconds of one pass over all readings.
double pass(Peer& peer)
{
    peer.clear();
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t k = 0; k < peer.observations; k++) peer.insert(k);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    peer.check();
    return took.count();
}

// Cells that an observation touches on an empty map, each counted once, for each of its readings: the mean of a sample.
double cells(Peer& peer, std::size_t readings)
{
    const std::size_t n = std::max<std::size_t>(1, std::min(readings, kSample) * peer.observations / readings);
    std::size_t sum = 0;
    for (std::size_t k = 0; k < n; k++)
    {
        peer.clear();
        peer.insert(k);
        sum += peer.touched();
    }
    return static_cast<double>(sum) * peer.observations / (static_cast<double>(n) * readings);
}
}  // namespace

int main(int count, char** arguments)
try
{
    if (count != 5) throw std::runtime_error("usage: peers PROGRAM READINGS WARM_UPS PASSES");
    const Readings readings = load(arguments[2]);
    Peer peer = make(arguments[1], readings);
    const int warm_ups = std::atoi(arguments[3]), passes = std::max(1, std::atoi(arguments[4]));
    const double touched = cells(peer, readings.size());
    for (int k = 0; k < warm_ups; k++) pass(peer);
    std::cout << "{\"version\": \"" << peer.version << "\", \"readings\": " << readings.size()
              << ", \"observations\": " << peer.observations << ", \"cells\": " << touched << ", \"seconds\": [";
    for (int k = 0; k < passes; k++) std::cout << (k ? ", " : "") << pass(peer);
    std::cout << "]}\n";
    return 0;
}
catch (const std::exception& e)
{
    std::cerr << "peers: " << e.what() << '\n';
    return 1;
}
