//! Graphs of equations against unknowns: the equation that gives each unknown, and the unknowns
//! that must be solved together.

/// Returns an equation for each unknown, found by augmenting paths. If there is no such matching,
/// returns the unknowns left without an equation.
pub(super) fn match_columns(depends: &[Vec<usize>], n: usize) -> Result<Vec<usize>, Vec<usize>> {
    let mut row_of: Vec<Option<usize>> = vec![None; n];
    for row in 0..depends.len() {
        augment(row, depends, &mut row_of);
    }
    let free: Vec<usize> = (0..n).filter(|&c| row_of[c].is_none()).collect();
    if free.is_empty() {
        Ok(row_of.into_iter().flatten().collect())
    } else {
        Err(free)
    }
}

/// Finds an equation's unknown by a breadth-first search for an augmenting path.
fn augment(start: usize, depends: &[Vec<usize>], row_of: &mut [Option<usize>]) {
    let mut from: Vec<Option<usize>> = vec![None; row_of.len()];
    let mut queue = std::collections::VecDeque::from([start]);
    while let Some(row) = queue.pop_front() {
        for &column in &depends[row] {
            if from[column].is_some() {
                continue;
            }
            from[column] = Some(row);
            match row_of[column] {
                Some(next) => queue.push_back(next),
                None => {
                    // walk back, shifting each equation to its new unknown
                    let mut column = column;
                    while let Some(row) = from[column] {
                        let previous = row_of.iter().position(|&r| r == Some(row));
                        row_of[column] = Some(row);
                        match previous {
                            Some(p) if row != start => column = p,
                            _ => return,
                        }
                    }
                    return;
                }
            }
        }
    }
}

/// Returns the strongly connected components, each after those that it needs (Tarjan 1972, with an
/// explicit stack).
pub(super) fn strong_components(needs: &[Vec<usize>]) -> Vec<Vec<usize>> {
    const UNSEEN: usize = usize::MAX;
    let n = needs.len();
    let (mut index, mut low, mut on_stack) = (vec![UNSEEN; n], vec![0; n], vec![false; n]);
    let (mut stack, mut components, mut counter) = (Vec::new(), Vec::new(), 0);
    for root in 0..n {
        if index[root] != UNSEEN {
            continue;
        }
        let mut calls = vec![(root, 0)];
        while let Some(&mut (node, ref mut edge)) = calls.last_mut() {
            if *edge == 0 {
                index[node] = counter;
                low[node] = counter;
                counter += 1;
                stack.push(node);
                on_stack[node] = true;
            }
            if let Some(&next) = needs[node].get(*edge) {
                *edge += 1;
                if index[next] == UNSEEN {
                    calls.push((next, 0));
                } else if on_stack[next] {
                    low[node] = low[node].min(index[next]);
                }
                continue;
            }
            calls.pop();
            if let Some(&(parent, _)) = calls.last() {
                low[parent] = low[parent].min(low[node]);
            }
            if low[node] == index[node] {
                let mut component = Vec::new();
                while let Some(member) = stack.pop() {
                    on_stack[member] = false;
                    component.push(member);
                    if member == node {
                        break;
                    }
                }
                components.push(component);
            }
        }
    }
    components
}
