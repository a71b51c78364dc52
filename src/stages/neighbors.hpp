#pragma once
// Stage neighbors: who is within the support radius h of whom, at the positions of the step's beginning.
//
// Law.  j is a neighbour of i if |x_i − x_j| < h (strict); a particle is not its own neighbour; coincident particles
//       are neighbours. Lists: fluid→fluid, fluid→boundary, fluid→sample, sample→fluid, sample→sample.
// Thin sheets. Liquid on one side of a cloth does not feel liquid on its other side: i and j are no neighbours if the
//       segment from x_i to x_j crosses the plane of p (x_p, normal n_p of its triangle) at a point nearer than 1.25 d to
//       x_p, with p = the sample nearest to x_i within h, or the one nearest to x_j (the first in the list of several).
//       It crosses if (x_i − x_p)·n_p and (x_j − x_p)·n_p differ in sign (0 counts as +). Of a segment shorter than
//       h = 2 d the crossing is within d of the foot of the nearer end, the nearest sample within cover_radius of that: so
//       far up to 1.25 d no pair is missed on an even sheet.
//       Beyond the sheet's rim nothing is parted: of the rim's edges near p (SampleSet::rim) let e be the one nearest to the
//       crossing c, (a, b) its nodes, o the third one of its triangle, m = (a − o) without its part along b − a. The pair
//       stays if (c − a)·m > 0. Where c is nearest to a corner that two of them share, m is the sum of both unit vectors m.
//       Of a flat sheet whose notches and holes are wider than d no pair is taken wrongly (tests/stages/rim_test.cpp).
//       (A sheet that parted a spacing beyond its rim as well let liquid above and below it there fall into each other
//       unseen: a loose sheet of 9 cm in 1.7 kg of still water made 0.19 J in 50 ms, 0.005 J with this.)
//       Without the rule (`neighbors: {through_cloth: true}`) liquid of kernel support h, twice the spacing, presses
//       through a sheet of no thickness.
// The same as stage porous_neighbors at the positions after advection, which adds sample→boundary.
// Order within a list is fixed: by cell, then by persistent id (fluid) or index (samples), so that sums are
// reproducible.
// Reads:  fluid_position, boundary_position, node_position.   Writes: the backend's neighbour lists.
