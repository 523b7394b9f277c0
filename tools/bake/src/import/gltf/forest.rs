use super::schema;
use crate::import::fault_list::FaultList;

/// The parent of every node. A child that does not exist, has a second parent, or is its own ancestor is a fault.
///
/// Takes time in proportion to the number of links, whatever their shape; nothing recurses.
pub(super) fn parents(nodes: &[schema::Node], faults: &mut FaultList) -> Vec<Option<usize>> {
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (number, node) in nodes.iter().enumerate() {
        for (place, child) in node.children.iter().enumerate() {
            let at = || format!("/nodes/{number}/children/{place}");
            match parents.get_mut(child.0) {
                None => faults.error(
                    at(),
                    format!("node {} does not exist; the file has {}", child.0, nodes.len()),
                ),
                Some(Some(first)) => {
                    let message = format!(
                        "node {} is already a child of node {first}; expected one parent",
                        child.0
                    );
                    faults.error(at(), message);
                }
                Some(parent) => *parent = Some(number),
            }
        }
    }
    report_cycles(&parents, faults);
    parents
}

/// Every node has at most one parent, so each walk upwards ends at a root, in a cycle, or in an earlier walk.
fn report_cycles(parents: &[Option<usize>], faults: &mut FaultList) {
    const UNSEEN: usize = usize::MAX;
    let mut walk_of = vec![UNSEEN; parents.len()];
    for start in 0..parents.len() {
        let mut at = Some(start);
        while let Some(node) = at {
            match walk_of.get_mut(node) {
                Some(walk) if *walk == UNSEEN => *walk = start,
                Some(walk) if *walk == start => {
                    let message = format!("node {node} is its own ancestor; expected a hierarchy without cycles");
                    faults.error(format!("/nodes/{node}"), message);
                    break;
                }
                _ => break,
            }
            at = parents.get(node).copied().flatten();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults_of(children: &[&[usize]]) -> Vec<String> {
        let nodes: Vec<schema::Node> = children
            .iter()
            .map(|children| serde_json::from_value(serde_json::json!({ "children": children })).unwrap())
            .collect();
        let mut faults = FaultList::default();
        parents(&nodes, &mut faults);
        faults.into_faults().into_iter().map(|fault| fault.path).collect()
    }

    #[test]
    fn one_fault_per_cycle() {
        assert_eq!(faults_of(&[&[1], &[2], &[1, 3], &[]]), ["/nodes/2/children/0"]);
        assert_eq!(faults_of(&[&[1], &[0], &[2], &[4], &[]]), ["/nodes/0", "/nodes/2"]);
    }

    #[test]
    fn a_tree_has_none() {
        assert!(faults_of(&[&[1, 3], &[2], &[], &[]]).is_empty());
    }
}
